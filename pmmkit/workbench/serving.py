"""Serving on loopback: a port that is free, a secret address, a browser."""

from __future__ import annotations

import secrets
import socket
from collections.abc import Callable
from contextlib import closing, suppress
from typing import Final

from pmmkit.errors import DataError
from pmmkit.workbench.application import application
from pmmkit.workbench.desk import Desk

LOOPBACK: Final = "127.0.0.1"
FIRST: Final = 8175
"""The port that is tried first."""
TRIES: Final = 40


def serve(
    desk: Desk, *, port: int | None = None, browser: bool = True, say: Callable[[str], None] = print
) -> None:
    """Serve a workbench until it is interrupted.

    Parameters
    ----------
    desk : Desk
        What it is about.
    port : int, optional
        On loopback; the next free one from `FIRST` if absent.
    browser : bool
        Whether a browser is opened.
    say : callable
        Told the address.

    Raises
    ------
    DataError
        If the port is taken.
    """
    import webbrowser

    import uvicorn

    with closing(listening(port)) as channel:
        number = int(channel.getsockname()[1])
        token = secrets.token_urlsafe(24)
        address = f"http://{LOOPBACK}:{number}/?token={token}"
        server = uvicorn.Server(
            uvicorn.Config(
                application(desk, token, number),
                log_level="warning",
                access_log=False,
                server_header=False,
                ws="none",
                timeout_graceful_shutdown=1,
            )
        )
        say(address)
        if desk.job.stand == "idle":
            desk.resume()
        if browser:
            webbrowser.open(address)
        try:
            # Ctrl+C is how it is meant to end.
            with suppress(KeyboardInterrupt):
                server.run(sockets=[channel])
        finally:
            desk.close()


def listening(port: int | None) -> socket.socket:
    """A socket of loopback, at a port or the first that is free.

    Raises
    ------
    DataError
        If the port, or all that were tried, are taken.
    """
    for number in [port] if port is not None else range(FIRST, FIRST + TRIES):
        channel = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        try:
            channel.bind((LOOPBACK, number))
            channel.listen(128)
        except OSError:
            channel.close()
            continue
        return channel
    where = f"Port {port} is" if port is not None else "The ports are"
    raise DataError(f"{where} taken. Name another one with --port.")
