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


class Url(str):
    """A text that looks like a URL, whether or not it is one that is read.

    Examples
    --------
    >>> Url("https://example.org/kcs/a.csv?signature=1b2c").shown
    'https://example.org/kcs/a.csv'
    """

    __slots__ = ()

    @classmethod
    def of(cls, place: str | Path) -> Url | None:
        """The URL that a text or path stands for; None where it is a path of this machine.

        A path that was a URL has lost one of its two slashes, which it gets back.

        Examples
        --------
        >>> Url.of(Path("https://example.org/kcs")), Url.of("s3://bucket/kcs/campaign.toml")
        ('https://example.org/kcs', 's3://bucket/kcs/campaign.toml')
        >>> Url.of("runs/PS_1.csv"), Url.of("C:/runs/PS_1.csv")
        (None, None)
        """
        text = place.as_posix() if isinstance(place, Path) else str(place)
        found = _BEGINNING.match(text)
        if found:
            return cls(f"{found[1].lower()}://{text[found.end() :]}")
        return cls(text) if "::" in text and ":/" in text else None

    def checked(self) -> Url:
        """The same, where it is read.

        Raises
        ------
        DataError
            If it chains protocols, is of another protocol, or holds a password.
        """
        if "::" in self:
            raise _refused(
                self.shown, "this is a chain of protocols.", "Name the URL of the object itself."
            )
        if self.scheme not in PACKAGES:
            raise _refused(
                self.shown,
                f"{self.scheme}:// is not read.",
                f"Known: {', '.join(PACKAGES)}. A file of this machine is named by its path alone.",
            )
        host = self.partition("://")[2].split("/")[0]
        if not host:
            raise _refused(
                self.shown, "no host or bucket is named.", f"Write {self.scheme}://HOST/PATH."
            )
        if self.scheme in WEB and "@" in host:
            raise _refused(
                f"{self.scheme}://{host.rpartition('@')[2]}",
                "the URL holds a password, which results would name.",
                "Leave it out, and write it into the file .netrc of your home folder.",
            )
        return self

    @property
    def scheme(self) -> str:
        """Its protocol."""
        return self.partition("://")[0]

    @property
    def host(self) -> str:
        """Its host or bucket."""
        return urlsplit(self.shown).netloc

    @property
    def shown(self) -> str:
        """As messages and results name it: without a query, which may be a key."""
        return re.split(r"[?#]", self)[0] if self.scheme in WEB else str(self)

    @property
    def name(self) -> str:
        """The name of the file behind it, fit for a file of this machine.

        Examples
        --------
        >>> Url("https://example.org/kcs/PS%201.csv?x=1").name, Url("s3://b/..").name
        ('PS 1.csv', '_')
        """
        last = self.shown.rstrip("/").rpartition("/")[2]
        name = unquote(last) if self.scheme in WEB else last
        return re.sub(r"[^\w .()+=@-]", "_", name)[-120:].strip(". ") or "_"

    def joined(self, name: str) -> Url | None:
        """The URL of a file that is named as seen from this folder; None where it lies outside.

        Examples
        --------
        >>> Url("https://example.org/kcs").joined("runs/PS 1.csv")
        'https://example.org/kcs/runs/PS%201.csv'
        >>> folder = Url("s3://bucket/kcs")
        >>> folder.joined("runs/../means.csv"), folder.joined("../x.csv"), folder.joined("/etc/a")
        ('s3://bucket/kcs/means.csv', None, None)
        """
        tidy = posixpath.normpath(name.replace("\\", "/"))
        if tidy.startswith(("/", "../")) or tidy in ("..", ".") or re.match("[A-Za-z]:", tidy):
            return None
        written = quote(tidy) if self.scheme in WEB else tidy
        return Url(f"{self.shown.rstrip('/')}/{written}")


def _refused(shown: str, message: str, remedy: str) -> DataError:
    return DataError(message, file=shown, remedy=remedy)
