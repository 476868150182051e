"""URLs, and what stands behind one: whether it is there, how large it is, in which state."""

from __future__ import annotations

import posixpath
import re
import uuid
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final
from urllib.parse import quote, unquote, urlsplit

from pmmkit.base import DataError

# Which text is a URL, which URLs are read, and where a name leads from one.


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


CONNECT: Final = 10.0
"""Seconds in which a web server has to answer."""
SILENCE: Final = 60.0
"""Seconds that a web server may send nothing."""
_STATES: Final = (
    "ETag",
    "etag",
    "Content-MD5",
    "content_md5",
    "md5Hash",
    "Digest",
    "generation",
    "Last-Modified",
    "LastModified",
    "last_modified",
    "mtime",
    "updated",
    "created",
)
"""Under which names stores say in which state an object is."""
_ABSENT: Final = (404, 410)
_FORBIDDEN: Final = (401, 403)
_ANSWERS: Final = ("status", "status_code", "code")
"""Where aiohttp, adlfs and gcsfs keep the answer of a server."""
_CIRCLE: Final = "TooManyRedirects"
"""What aiohttp raises after ten redirects."""
_SHOWN: Final = 200
"""Characters that are shown of a redirect to what is no URL with a host."""
_NO_KEYS: Final = ("NoCredentialsError", "ClientAuthenticationError", "DefaultCredentialsError")


@dataclass(frozen=True, kw_only=True)
class Origin:
    """An object in the state in which it was first seen.

    Parameters
    ----------
    url : Url
        Where it is.
    state : str
        Tag, checksum or time of change by which its store tells one state from another.
    size : int or None
        Bytes, where the store says it.
    stated : bool
        Whether the store tells states apart; else `state` stands for this one look.
    """

    url: Url
    state: str = field(repr=False)
    size: int | None = field(default=None, repr=False)
    stated: bool = field(default=True, repr=False)

    @classmethod
    def of(cls, url: Url) -> Origin | None:
        """What stands behind a URL now; None if nothing does.

        Raises
        ------
        DataError
            If it is not read, needs a package, is forbidden, or cannot be reached.
        """
        system = system_of(url.checked())
        try:
            system.invalidate_cache()
            found = system.info(url)
        except Exception as error:  # stores raise whatever their libraries raise
            if is_absent(error):
                return None
            raise told(url, error) from error
        if found.get("type") == "directory":
            return None
        said = {name: str(found[name]) for name in _STATES if found.get(name)}
        size = found.get("size")
        state = repr((size, said)) if said else uuid.uuid4().hex
        return cls(url=url, state=state, size=size, stated=bool(said))

    @property
    def name(self) -> str:
        """Name of its copy."""
        return self.url.name

    @property
    def shown(self) -> str:
        """As messages and results name it."""
        return self.url.shown


def system_of(url: Url) -> Any:
    """fsspec's view of the store behind a URL."""
    scheme = url.scheme
    options: Mapping[str, Any] = {}
    try:
        import fsspec

        if scheme in WEB:
            from aiohttp import ClientTimeout, TraceConfig

            limits = ClientTimeout(total=None, sock_connect=CONNECT, sock_read=SILENCE)
            watch = TraceConfig()
            watch.on_request_redirect.append(_stay)
            options = {
                "client_kwargs": {"trust_env": True, "timeout": limits, "trace_configs": [watch]}
            }
        return fsspec.filesystem(scheme, **options)
    except ImportError as error:
        more = "" if scheme in WEB else f" {PACKAGES[scheme]}"
        raise DataError(
            f"reading {scheme}:// needs packages that are not installed ({error}).",
            file=url.shown,
            remedy=f"pip install 'pmmkit[remote]'{more}, on all machines that read.",
        ) from error
    except Exception as error:  # stores look for keys when they are made
        raise told(url, error) from error


class _Elsewhere(Exception):
    """A server leads to a place that nobody named."""


async def _stay(_session: object, _context: object, redirect: Any) -> None:
    """Refuse a redirect to another protocol, host or port, before anything is sent there."""
    named = redirect.response.headers.get("Location", "")
    try:
        target = redirect.url.join(type(redirect.url)(named))
        same = target.origin() == redirect.url.origin()
    except ValueError:  # no host, as in file:///, or no URL at all
        raise _Elsewhere(Url(named).shown[:_SHOWN]) from None
    if not same:
        raise _Elsewhere(Url(str(target)).shown)


def is_absent(error: BaseException) -> bool:
    """Whether an error says that there is no such object, and not that it cannot be reached."""
    chain = list(_causes(error))
    states = [state for item in chain if (state := _state_of(item)) is not None]
    if states:
        return states[-1] in _ABSENT
    return isinstance(chain[-1], (FileNotFoundError, IsADirectoryError))


def told(url: Url, error: BaseException) -> DataError:
    """What is wrong with a store, and what can be done."""
    chain = list(_causes(error))
    scheme, host = url.scheme, url.host
    if any(
        _state_of(item) in _FORBIDDEN
        or isinstance(item, PermissionError)
        or type(item).__name__ in _NO_KEYS
        for item in chain
    ):
        keys = (
            "the file .netrc of your home folder"
            if scheme in WEB
            else f"the environment or files where {PACKAGES[scheme]} looks for them, on all "
            "machines that read"
        )
        return DataError(
            f"{host} gives no permission.",
            file=url.shown,
            remedy=f"See whether the name is right; keys are taken from {keys}.",
        )
    if isinstance(chain[-1], _Elsewhere):
        return DataError(
            f"{host} leads to {chain[-1]}, and a redirect to another place is not followed.",
            file=url.shown,
            remedy="Name that URL itself, if you trust it.",
        )
    if any(type(item).__name__ == _CIRCLE for item in chain):
        return DataError(
            f"{host} leads from one place to the next and never to a file.",
            file=url.shown,
            remedy="Name the URL where the file itself lies.",
        )
    last = str(chain[-1]).split("?")[0].strip() or type(chain[-1]).__name__
    return DataError(
        f"{host} cannot be reached or broke off ({last}).",
        file=url.shown,
        remedy="Try again: what was read is kept.",
    )


def _causes(error: BaseException) -> Iterator[BaseException]:
    """An error and what it was raised from, that last."""
    known: BaseException | None = error
    for _ in range(10):
        if known is None:
            return
        yield known
        known = known.__cause__


def _state_of(error: BaseException) -> int | None:
    """What a server answered, as the packages of the stores keep it."""
    for name in _ANSWERS:
        if isinstance(state := getattr(error, name, None), int):
            return state
    answer = getattr(error, "response", None)
    about = answer.get("ResponseMetadata") if isinstance(answer, Mapping) else None
    state = about.get("HTTPStatusCode") if isinstance(about, Mapping) else None
    return state if isinstance(state, int) else None
