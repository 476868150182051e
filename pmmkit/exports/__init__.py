"""Models, tables, campaigns and tracks for other programs."""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.exports.fmu.unit import approach_of
    from pmmkit.exports.programme.write import programme_files, refuse_taken
    from pmmkit.exports.write import ENDINGS, export, file_name, read_subject

__all__ = [
    "ENDINGS",
    "approach_of",
    "export",
    "file_name",
    "programme_files",
    "read_subject",
    "refuse_taken",
]

lazy(__name__)
