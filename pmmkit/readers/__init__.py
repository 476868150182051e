"""Readers of measured files: a class for each format, in a file or folder of its own.

To add a format, write a file with a class derived from `Reader` into this folder, or into a package
of your own that names the class in the entry point group ``pmmkit.readers``.
"""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.readers.archive.members import Contents, contents_of, joined
    from pmmkit.readers.base import (
        HEAD,
        Cell,
        Cells,
        Choose,
        Columns,
        Options,
        Request,
        fault,
        head_of,
        numbers_of,
        to_number,
    )
    from pmmkit.readers.hdf5.datasets import SIGNATURE, declared_bytes, is_saved_campaign, open_hdf5
    from pmmkit.readers.reader import Reader
    from pmmkit.readers.registry import READERS, files_of, format_of, reader_for, recognise
    from pmmkit.readers.rows import as_text, filled_in, matching_rows, no_column
    from pmmkit.readers.saved import SavedCampaign
    from pmmkit.readers.saved.file import FORMAT, SCHEMA, checksum, loader_of, opened, read_index
    from pmmkit.readers.saved.group import attribute, safe_names, unfit, write_group
    from pmmkit.readers.text import DelimitedText
    from pmmkit.readers.text.csv import columns
    from pmmkit.readers.text.layout import TextLayout, layout_of, mostly_numbers, text_of

__all__ = [
    "FORMAT",
    "HEAD",
    "READERS",
    "SCHEMA",
    "SIGNATURE",
    "Cell",
    "Cells",
    "Choose",
    "Columns",
    "Contents",
    "DelimitedText",
    "Options",
    "Reader",
    "Request",
    "SavedCampaign",
    "TextLayout",
    "as_text",
    "attribute",
    "checksum",
    "columns",
    "contents_of",
    "declared_bytes",
    "fault",
    "files_of",
    "filled_in",
    "format_of",
    "head_of",
    "is_saved_campaign",
    "joined",
    "layout_of",
    "loader_of",
    "matching_rows",
    "mostly_numbers",
    "no_column",
    "numbers_of",
    "open_hdf5",
    "opened",
    "read_index",
    "reader_for",
    "recognise",
    "safe_names",
    "text_of",
    "to_number",
    "unfit",
    "write_group",
]

lazy(__name__)
