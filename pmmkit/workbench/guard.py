"""Who may ask: an address with a key that counts once, then the cookie; own Host and Origin."""

from __future__ import annotations

import asyncio
import secrets
from collections.abc import Awaitable, Callable, MutableMapping
from dataclasses import dataclass, field
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


PATIENCE: Final = 20.0
"""Seconds that the next part of a request may take to come."""


@dataclass(frozen=True, kw_only=True)
class Guard:
    """Lets through what comes from the page of this server, and puts headers on every answer.

    `token`: the secret of the cookie. `once`: keys of addresses that were not opened yet; each
    counts once, and the cookie alone from then on.
    """

    app: App
    token: str
    port: int
    once: set[str] = field(default_factory=set)

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
        elif _key(scope):
            self.once.discard(_key(scope))
            cookie = f"{self.cookie}={self.token}; HttpOnly; SameSite=Strict; Path=/"
            await (_led if _from_elsewhere(headers) else _sent)(guarded, cookie)
        else:
            await self.app(scope, _patiently(receive), guarded)

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
        fresh = any(_same(_key(scope), key) for key in self.once)
        if not fresh and _from_elsewhere(headers):
            return 403, "This request comes from another page."
        if not fresh and not self._known(headers):
            return 403, (
                "This address was opened before, and its key counts once: go on in the browser "
                "where it was opened, or end pmmkit workbench and start it again."
                if _key(scope)
                else "Open the address that pmmkit workbench printed: it holds the key."
            )
        return _too_large(headers, LIMITS.get(scope["path"], LARGEST)) if writes else None

    def _known(self, headers: dict[bytes, bytes]) -> bool:
        try:
            cookies = SimpleCookie(headers.get(b"cookie", b"").decode("latin-1"))
        except CookieError:
            cookies = SimpleCookie()
        return self.cookie in cookies and _same(cookies[self.cookie].value, self.token)


def _same(given: str, secret: str) -> bool:
    return secrets.compare_digest(given.encode("utf-8", "replace"), secret.encode())


def _key(scope: Scope) -> str:
    """The key of an address, which the page alone has; a GET is all that it is good for."""
    return _query(scope, "token") if scope["path"] == "/" and scope["method"] == "GET" else ""


def _patiently(receive: Receive) -> Receive:
    """What comes in, which is waited for as long as a request is not whole."""
    whole = False

    async def received() -> MutableMapping[str, Any]:
        nonlocal whole
        if whole:
            return await receive()
        message = await asyncio.wait_for(receive(), PATIENCE)
        whole = not message.get("more_body", False)
        return message

    return received


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
    kind = (b"content-type", b"text/plain; charset=utf-8")
    await _answer(send, status, text.encode(), kind)


async def _answer(send: Send, status: int, body: bytes, *headers: tuple[bytes, bytes]) -> None:
    every = [*headers, (b"content-length", b"%d" % len(body))]
    await send({"type": "http.response.start", "status": status, "headers": every})
    await send({"type": "http.response.body", "body": body})


def _from_elsewhere(headers: dict[bytes, bytes]) -> bool:
    return headers.get(b"sec-fetch-site", b"none") not in (b"none", b"same-origin")


async def _sent(send: Send, cookie: str) -> None:
    """The key goes out of an address that was typed and into a cookie; its fragment stays."""
    await _answer(send, 303, b"", (b"location", b"/"), (b"set-cookie", cookie.encode()))


async def _led(send: Send, cookie: str) -> None:
    """The same for who comes from a file: a page leads on, as after a redirect a browser that came
    from elsewhere sends no cookie that is ``SameSite=Strict``."""
    # An icon of its own, or browsers ask for one.
    body = (
        b'<!doctype html><meta charset="utf-8"><link rel="icon" href="data:,">'
        b'<meta http-equiv="refresh" content="0; url=/">'
    )
    kind = (b"content-type", b"text/html; charset=utf-8")
    await _answer(send, 200, body, kind, (b"set-cookie", cookie.encode()))
