"""Files and folders that are written whole or not at all, TOML, JSON and what lies behind a URL."""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.files.json_text import from_json, plain, readable, to_json
    from pmmkit.files.places import (
        atomic_folder,
        atomic_path,
        cache_folder,
        datasets_folder,
        free_folder,
        is_empty_place,
        is_intact,
        matching,
        sha256,
        write_results,
        write_text,
    )
    from pmmkit.files.remote.copies import local_copy
    from pmmkit.files.remote.objects import Origin, Url
    from pmmkit.files.toml import (
        CAMPAIGN,
        MODEL,
        check_numbers,
        read_toml,
        refuse_other,
        toml_string,
        toml_text,
    )

__all__ = [
    "CAMPAIGN",
    "MODEL",
    "Origin",
    "Url",
    "atomic_folder",
    "atomic_path",
    "cache_folder",
    "check_numbers",
    "datasets_folder",
    "free_folder",
    "from_json",
    "is_empty_place",
    "is_intact",
    "local_copy",
    "matching",
    "plain",
    "read_toml",
    "readable",
    "refuse_other",
    "sha256",
    "to_json",
    "toml_string",
    "toml_text",
    "write_results",
    "write_text",
]

lazy(__name__)
