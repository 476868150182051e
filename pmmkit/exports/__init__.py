"""Models, tables, campaigns and tracks for other programs."""

from pmmkit.exports.fmu.unit import model_to_fmu
from pmmkit.exports.matlab.model import model_to_mss
from pmmkit.exports.matlab.table import table_to_mss
from pmmkit.exports.shipmmg import model_to_shipmmg
from pmmkit.exports.write import ENDINGS, FORMATS, export

__all__ = [
    "ENDINGS",
    "FORMATS",
    "export",
    "model_to_fmu",
    "model_to_mss",
    "model_to_shipmmg",
    "table_to_mss",
]
