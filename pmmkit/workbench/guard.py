"""Who may ask: the token of the address, this server's own Host and Origin, bodies of a size."""

from __future__ import annotations

import secrets
from collections.abc import Awaitable, Callable, MutableMapping
from dataclasses import dataclass
from http.cookies import CookieError, SimpleCookie
from types import MappingProxyType
from typing import Any, Final
from urllib.parse import parse_qs

from pmmkit.workbench import incoming

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

LARGEST: Final = 1_000_000
"""Bytes of a request's body."""
LIMITS: Final = MappingProxyType({"/api/drop": incoming.LARGEST})
"""The same where files are taken."""
POLICY: Final = "; ".join(
    (
        "default-src 'none'",
        "script-src 'self'",
        "style-src 'self'",
        "img-src 'self' data:",
        "connect-src 'self'",
        "base-uri 'none'",
        "form-action 'none'",
        "frame-ancestors 'none'",
    )
)
HEADERS: Final = (
    (b"content-security-policy", POLICY.encode()),
    (b"x-content-type-options", b"nosniff"),
    (b"referrer-policy", b"no-referrer"),
    (b"cross-origin-opener-policy", b"same-origin"),
    (b"cross-origin-resource-policy", b"same-origin"),
    (b"cache-control", b"no-store"),
)


@dataclass(frozen=True, kw_only=True)
class Guard:
    """Lets through what comes from the page of this server, and puts headers on every answer.

    `token`: the secret of the address that was opened.
    """

    app: App
    token: str
    port: int

    @property
    def cookie(self) -> str:
        """Its name: cookies of one host do not know of ports."""
        return f"pmmkit_{self.port}"

    @property
    def hosts(self) -> tuple[str, ...]:
        """How a browser on this machine calls the server."""
        return (f"127.0.0.1:{self.port}", f"localhost:{self.port}")

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request of ASGI."""
        if scope["type"] == "lifespan":
            await self.app(scope, receive, send)
            return
        if scope["type"] != "http":
            return
        headers = {key.lower(): value for key, value in scope["headers"]}
        guarded = _with_headers(send)
        refusal = self._refusal(scope, headers)
        if refusal is not None:
            await _say(guarded, *refusal)
        elif _query(scope, "token") and scope["path"] == "/":
            await _welcome(
                guarded, f"{self.cookie}={self.token}; HttpOnly; SameSite=Strict; Path=/"
            )
        else:
            await self.app(scope, receive, guarded)

    def _refusal(self, scope: Scope, headers: dict[bytes, bytes]) -> tuple[int, str] | None:
        host = headers.get(b"host", b"").decode("latin-1")
        if host not in self.hosts:
            return 421, "This server answers to its own address alone."
        origin = headers.get(b"origin")
        writes = scope["method"] not in ("GET", "HEAD")
        if (origin is None and writes) or (
            origin is not None and origin.decode("latin-1") != f"http://{host}"
        ):
            return 403, "This request comes from another page."
        if headers.get(b"sec-fetch-site", b"none") not in (b"none", b"same-origin"):
            return 403, "This request comes from another page."
        if not self._known(scope, headers):
            return 403, "Open the address that pmmkit workbench printed: it holds the key."
        return _too_large(headers, LIMITS.get(scope["path"], LARGEST)) if writes else None

    def _known(self, scope: Scope, headers: dict[bytes, bytes]) -> bool:
        given = _query(scope, "token") if scope["path"] == "/" else ""
        try:
            cookies = SimpleCookie(headers.get(b"cookie", b"").decode("latin-1"))
        except CookieError:
            cookies = SimpleCookie()
        kept = cookies[self.cookie].value if self.cookie in cookies else ""
        return any(
            secrets.compare_digest(text.encode("utf-8", "replace"), self.token.encode())
            for text in (given, kept)
        )


def _query(scope: Scope, name: str) -> str:
    try:
        query: bytes = scope.get("query_string", b"")
        return parse_qs(query.decode("latin-1")).get(name, [""])[0]
    except ValueError:
        return ""


def _too_large(headers: dict[bytes, bytes], largest: int) -> tuple[int, str] | None:
    try:
        size = int(headers.get(b"content-length", b""))
    except ValueError:
        return 411, "A request says how long it is."
    if 0 <= size <= largest:
        return None
    return 413, f"More than {largest // 1_000_000} MB at once are not taken."


def _with_headers(send: Send) -> Send:
    async def sent(message: MutableMapping[str, Any]) -> None:
        if message["type"] == "http.response.start":
            message = {**message, "headers": [*message.get("headers", ()), *HEADERS]}
        await send(message)

    return sent


async def _say(send: Send, status: int, text: str) -> None:
    body = text.encode()
    kind = [(b"content-type", b"text/plain; charset=utf-8"), (b"content-length", b"%d" % len(body))]
    await send({"type": "http.response.start", "status": status, "headers": kind})
    await send({"type": "http.response.body", "body": body})


async def _welcome(send: Send, cookie: str) -> None:
    """The token goes out of the address and into a cookie."""
    headers = [(b"location", b"/"), (b"set-cookie", cookie.encode()), (b"content-length", b"0")]
    await send({"type": "http.response.start", "status": 303, "headers": headers})
    await send({"type": "http.response.body", "body": b""})
