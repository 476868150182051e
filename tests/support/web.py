"""A web server on the loopback interface that can fail as servers do."""

from __future__ import annotations

import threading
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from urllib.parse import unquote, urlsplit


@dataclass
class Web:
    """What is served: contents by path, states or other places that are answered instead, keys that
    came, and what was asked."""

    url: str
    files: dict[str, bytes]
    states: dict[str, int] = field(default_factory=dict)
    cut: dict[str, int] = field(default_factory=dict)
    moved: dict[str, str] = field(default_factory=dict)
    keys: Counter[str] = field(default_factory=Counter)
    asked: Counter[tuple[str, str]] = field(default_factory=Counter)
    tagged: bool = True


@contextmanager
def served_web(files: Mapping[str, str | bytes]) -> Iterator[Web]:
    """Serve texts by their paths; ``cut`` says how often an answer ends half-way."""
    texts = {
        f"/{name}": text.encode() if isinstance(text, str) else text for name, text in files.items()
    }

    class Handler(BaseHTTPRequestHandler):
        def do_HEAD(self) -> None:
            self._answer(b"")

        def do_GET(self) -> None:
            self._answer(None)

        def _answer(self, body: bytes | None) -> None:
            path = unquote(urlsplit(self.path).path)
            web.asked[self.command, path] += 1
            web.keys[self.headers.get("Authorization", "")] += 1
            content = web.files.get(path)
            if path in web.moved:
                self.send_response(302)
                self.send_header("Location", web.moved[path])
                self.send_header("Content-Length", "0")
                self.end_headers()
                return
            state = web.states.get(path, 404 if content is None else 200)
            self.send_response(state)
            if state != 200 or content is None:
                self.send_header("Content-Length", "0")
                self.end_headers()
                return
            self.send_header("Content-Length", str(len(content)))
            if web.tagged:
                self.send_header("ETag", f'"{hash(content):x}"')
            self.end_headers()
            if body is None and web.cut.get(path, 0) > 0:
                web.cut[path] -= 1
                self.wfile.write(content[: len(content) // 2])
                self.close_connection = True
            elif body is None:
                self.wfile.write(content)

        def log_message(self, *_: object) -> None:
            """Nothing."""

    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        web = Web(url=f"http://127.0.0.1:{server.server_port}", files=texts)
        thread = threading.Thread(target=server.serve_forever, args=(0.02,), daemon=True)
        thread.start()
        try:
            yield web
        finally:
            server.shutdown()
            thread.join()
