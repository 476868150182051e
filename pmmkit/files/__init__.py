"""Files and folders that are written whole or not at all, TOML, JSON and what lies behind a URL."""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.files.json_text import from_json, plain, readable, to_json
    from pmmkit.files.places import (
        atomic_folder,
        atomic_path,
        cache_folder,
        check_folder,
        datasets_folder,
        first_free,
        free_file,
        free_folder,
        is_empty_place,
        is_intact,
        matching,
        seal,
        sha256,
        write_results,
        write_text,
    )
    from pmmkit.files.remote.copies import local_copy
    from pmmkit.files.remote.objects import Origin, look
    from pmmkit.files.remote.urls import as_url, checked, joined, leads_out, shown_url
    from pmmkit.files.toml import CAMPAIGN, MODEL, check_numbers, read_toml, refuse_other, toml_text

__all__ = [
    "CAMPAIGN",
    "MODEL",
    "Origin",
    "as_url",
    "atomic_folder",
    "atomic_path",
    "cache_folder",
    "check_folder",
    "check_numbers",
    "checked",
    "datasets_folder",
    "first_free",
    "free_file",
    "free_folder",
    "from_json",
    "is_empty_place",
    "is_intact",
    "joined",
    "leads_out",
    "local_copy",
    "look",
    "matching",
    "plain",
    "read_toml",
    "readable",
    "refuse_other",
    "seal",
    "sha256",
    "shown_url",
    "to_json",
    "toml_text",
    "write_results",
    "write_text",
]

lazy(__name__)
