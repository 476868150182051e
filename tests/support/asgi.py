"""Requests to an ASGI application in this process, as raw as wanted."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any
from urllib.parse import urlsplit


@dataclass(frozen=True)
class Answer:
    """Status, headers and body of an answer."""

    status: int
    headers: Mapping[str, str]
    body: bytes

    @property
    def text(self) -> str:
        return self.body.decode()

    @property
    def json(self) -> Any:
        return json.loads(self.body)


def ask(
    app: Any,
    address: str,
    *,
    method: str = "GET",
    headers: Sequence[tuple[bytes, bytes]] = (),
    body: bytes = b"",
) -> Answer:
    """The answer to one request."""
    parts = urlsplit(address)
    scope = {
        "type": "http",
        "asgi": {"version": "3.0"},
        "http_version": "1.1",
        "method": method,
        "scheme": "http",
        "path": parts.path,
        "raw_path": parts.path.encode(),
        "query_string": parts.query.encode(),
        "root_path": "",
        "headers": list(headers),
        "client": ("127.0.0.1", 50000),
        "server": ("127.0.0.1", 80),
    }
    sent: list[Any] = []

    bodies = [body]

    async def receive() -> Any:
        if not bodies:
            await asyncio.Event().wait()
        return {"type": "http.request", "body": bodies.pop(), "more_body": False}

    async def send(message: Any) -> None:
        sent.append(message)

    asyncio.run(app(scope, receive, send))
    first = sent[0]
    found = {key.decode().lower(): value.decode() for key, value in first["headers"]}
    return Answer(first["status"], found, b"".join(item.get("body", b"") for item in sent[1:]))


@dataclass(frozen=True)
class Browser:
    """A page of the workbench: it sends what a browser would send."""

    app: Any
    port: int
    token: str

    @property
    def own(self) -> list[tuple[bytes, bytes]]:
        """Headers of its own requests."""
        return [
            (b"host", f"127.0.0.1:{self.port}".encode()),
            (b"origin", f"http://127.0.0.1:{self.port}".encode()),
            (b"cookie", f"pmmkit_{self.port}={self.token}".encode()),
        ]

    def get(self, address: str) -> Answer:
        return ask(self.app, address, headers=self.own)

    def post(self, address: str, content: Any) -> Answer:
        body = json.dumps(content).encode()
        length = (b"content-length", str(len(body)).encode())
        return ask(self.app, address, method="POST", headers=[*self.own, length], body=body)
