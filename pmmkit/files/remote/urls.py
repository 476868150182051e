"""Which text is a URL, which URLs are read, and where a name leads from one."""

from __future__ import annotations

import posixpath
import re
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Final
from urllib.parse import quote, unquote, urlsplit

from pmmkit.base import DataError

PACKAGES: Final[Mapping[str, str]] = MappingProxyType(
    {
        "https": "aiohttp",
        "http": "aiohttp",
        "s3": "s3fs",
        "gs": "gcsfs",
        "gcs": "gcsfs",
        "az": "adlfs",
        "abfs": "adlfs",
    }
)
"""Protocols that are read, each with the package that speaks it beside fsspec."""
WEB: Final = ("https", "http")
"""Protocols whose names are written with %20 and the like, and that may end in a query."""
_BEGINNING: Final = re.compile(r"([A-Za-z][A-Za-z0-9+.-]+):/+")


def as_url(place: str | Path) -> str | None:
    """The URL that a text or path stands for; None where it is a path of this machine.

    A path that was a URL has lost one of its two slashes, which it gets back.

    Parameters
    ----------
    place : str or Path
        What somebody typed, or a campaign file names.

    Returns
    -------
    str or None
        Anything that looks like a URL, `checked` or not.

    Examples
    --------
    >>> as_url(Path("https://example.org/kcs")), as_url("s3://bucket/kcs/campaign.toml")
    ('https://example.org/kcs', 's3://bucket/kcs/campaign.toml')
    >>> as_url("runs/PS_1.csv"), as_url("C:/runs/PS_1.csv")
    (None, None)
    """
    text = place.as_posix() if isinstance(place, Path) else str(place)
    found = _BEGINNING.match(text)
    if found:
        return f"{found[1].lower()}://{text[found.end() :]}"
    return text if "::" in text and ":/" in text else None


def checked(url: str) -> str:
    """A URL that is read.

    Parameters
    ----------
    url : str
        As `as_url` gives it.

    Raises
    ------
    DataError
        If it chains protocols, is of another protocol, or holds a password.

    Examples
    --------
    >>> checked("https://example.org/kcs/campaign.toml")
    'https://example.org/kcs/campaign.toml'
    """
    shown = shown_url(url)
    if "::" in url:
        raise _refused(shown, "this is a chain of protocols.", "Name the URL of the object itself.")
    scheme = scheme_of(url)
    if scheme not in PACKAGES:
        raise _refused(
            shown,
            f"{scheme}:// is not read.",
            f"Known: {', '.join(PACKAGES)}. A file of this machine is named by its path alone.",
        )
    host = url.partition("://")[2].split("/")[0]
    if not host:
        raise _refused(shown, "no host or bucket is named.", f"Write {scheme}://HOST/PATH.")
    if scheme in WEB and "@" in host:
        raise _refused(
            f"{scheme}://{host.rpartition('@')[2]}",
            "the URL holds a password, which results would name.",
            "Leave it out, and write it into the file .netrc of your home folder.",
        )
    return url


def _refused(shown: str, message: str, remedy: str) -> DataError:
    return DataError(message, file=shown, remedy=remedy)


def scheme_of(url: str) -> str:
    """The protocol of a URL."""
    return url.partition("://")[0]


def joined(base: str, name: str) -> str | None:
    """The URL of a file that is named as seen from a folder; None where it lies outside.

    Parameters
    ----------
    base : str
        URL of the folder.
    name : str
        As a campaign file writes it.

    Examples
    --------
    >>> joined("https://example.org/kcs", "runs/PS 1.csv")
    'https://example.org/kcs/runs/PS%201.csv'
    >>> joined("s3://bucket/kcs", "runs/../means.csv"), joined("s3://bucket/kcs", "../x.csv")
    ('s3://bucket/kcs/means.csv', None)
    """
    if leads_out(name):
        return None
    tidy = posixpath.normpath(name.replace("\\", "/"))
    written = quote(tidy) if scheme_of(base) in WEB else tidy
    return f"{shown_url(base).rstrip('/')}/{written}"


def leads_out(name: str) -> bool:
    """Whether a name leads out of the folder that it is seen from.

    Parameters
    ----------
    name : str
        As a campaign file writes it.

    Examples
    --------
    >>> leads_out("runs/../a.csv"), leads_out("../a.csv"), leads_out("/etc/a.csv")
    (False, True, True)
    """
    tidy = posixpath.normpath(name.replace("\\", "/"))
    return tidy.startswith(("/", "../")) or tidy in ("..", ".") or bool(re.match("[A-Za-z]:", tidy))


def shown_url(url: str) -> str:
    """A URL as messages and results name it: without a query, which may be a key.

    Parameters
    ----------
    url : str
        Anything that looks like one.

    Examples
    --------
    >>> shown_url("https://example.org/a.csv?signature=1b2c")
    'https://example.org/a.csv'
    """
    return re.split(r"[?#]", url)[0] if scheme_of(url) in WEB else url


def shown_name(url: str) -> str:
    """The name of a file behind a URL, fit for a file of this machine.

    Examples
    --------
    >>> shown_name("https://example.org/kcs/PS%201.csv?x=1"), shown_name("s3://b/..")
    ('PS 1.csv', '_')
    """
    bare = shown_url(url)
    last = bare.rstrip("/").rpartition("/")[2]
    name = unquote(last) if scheme_of(url) in WEB else last
    return re.sub(r"[^\w .()+=@-]", "_", name)[-120:].strip(". ") or "_"


def host_of(url: str) -> str:
    """The host or bucket of a URL."""
    return urlsplit(url).netloc
