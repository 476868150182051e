"""A workbench that is served in a thread of its own."""

from __future__ import annotations

import threading
from contextlib import contextmanager

from pmmkit.workbench.application import application, listening, protocol


@contextmanager
def served(desk):
    """The address of a server in a thread of its own."""
    import uvicorn

    channel = listening(None)
    port = channel.getsockname()[1]
    config = uvicorn.Config(
        application(desk, "secret", port, once=["key"]),
        log_level="warning",
        ws="none",
        http=protocol(),
    )
    server = uvicorn.Server(config)
    thread = threading.Thread(target=server.run, kwargs={"sockets": [channel]}, daemon=True)
    thread.start()
    try:
        yield f"http://127.0.0.1:{port}/?token=key"
    finally:
        server.should_exit = True
        thread.join(10)
        channel.close()
