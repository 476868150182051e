"""Readers of measured files: a class for each format, in a file or folder of its own.

To add a format, write a file with a class derived from `Reader` into this folder, or into a package
of your own that names the class in the entry point group ``pmmkit.readers``.
"""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.readers.archive.members import Contents
    from pmmkit.readers.base import (
        Cell,
        Cells,
        Choose,
        Columns,
        Options,
        Reader,
        Request,
        as_text,
        head_of,
        to_number,
    )
    from pmmkit.readers.hdf5.datasets import SIGNATURE, declared_bytes, open_hdf5
    from pmmkit.readers.registry import READERS, reader_for, recognise
    from pmmkit.readers.saved.file import CampaignWriter, safe_names, saved_index
    from pmmkit.readers.text.layout import TextLayout, text_of

__all__ = [
    "READERS",
    "SIGNATURE",
    "CampaignWriter",
    "Cell",
    "Cells",
    "Choose",
    "Columns",
    "Contents",
    "Options",
    "Reader",
    "Request",
    "TextLayout",
    "as_text",
    "declared_bytes",
    "head_of",
    "open_hdf5",
    "reader_for",
    "recognise",
    "safe_names",
    "saved_index",
    "text_of",
    "to_number",
]

lazy(__name__)
