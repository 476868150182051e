"""The addresses of the server and what each gives."""

from __future__ import annotations

import json
import logging
import os
import secrets
import socket
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import closing, contextmanager, suppress
from functools import partial
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from pmmkit.base import DataError, PmmkitError
from pmmkit.files import plain
from pmmkit.views import asked_of, page_file, with_histories
from pmmkit.workbench.data_routes import (
    count_of,
    data_routes,
    given_text,
    given_texts,
    place_in,
    place_of,
    revision_of,
    text_of,
)
from pmmkit.workbench.desk import Desk, StaleRevision
from pmmkit.workbench.guard import PATIENCE, Guard
from pmmkit.workbench.saved import WorkbenchState

if TYPE_CHECKING:
    from starlette.applications import Starlette
    from starlette.requests import Request
    from starlette.responses import Response


# The page of a workbench with its state in one HTML file.


def frozen_page(desk: Desk) -> str:
    """The page of a workbench as one file.

    Parameters
    ----------
    desk : Desk
        With something open. What was not asked yet is not in the file.
    """
    return page_file(answers(desk))


def answers(desk: Desk) -> dict[str, Any]:
    """What the page asks, by the words it asks with."""
    state = desk.page()
    count = len(state.get("steps", ()))
    found: dict[str, Any] = {"state": {**state, "job": {**state["job"], "stand": "idle"}}}
    campaigns = range(len(state.get("campaigns", ())) or 1)
    for number in range(count + 1):
        for of in campaigns:
            found[asked_of(f"misfit {number}", of)] = desk.misfit(number, of)
    asked: Mapping[str, Callable[[], Any]] = {
        "missing": desk.missing,
        "fall": desk.fall,
        "turns": desk.turns,
        **{asked_of("checks", of): partial(desk.checks, of) for of in campaigns},
        **{asked_of("derivatives", of): partial(desk.derivatives, of) for of in campaigns},
        **{asked_of("runs 0", of): partial(desk.runs, 0, of) for of in campaigns},
    }
    for name, give in asked.items():
        try:
            found[name] = give()
        except PmmkitError:
            found[name] = None
    return with_histories(found, count, len(campaigns), desk.history)


STATIC: Final = Path(str(files("pmmkit.views"))) / "static"
ORDERED: Final = ("orders", "conditions")
"""Groups of settings with which a manoeuvre may be sailed."""


def application(desk: Desk, token: str, port: int, once: Iterable[str] = ()) -> Guard:
    """The guarded application, with the keys of addresses that are good once."""
    return Guard(app=_routes(desk), token=token, port=port, once=set(once))


async def _broken_off(_request: Request, error: Exception) -> Response:
    """What is said of a request of which the rest did not come."""
    from starlette.responses import PlainTextResponse

    logging.getLogger("uvicorn.error").warning("A request broke off; nothing of it was kept.")
    late = isinstance(error, TimeoutError)
    return PlainTextResponse("The rest of the request did not come.", 408 if late else 400)


def _routes(desk: Desk) -> Starlette:
    from starlette.applications import Starlette
    from starlette.requests import ClientDisconnect
    from starlette.responses import FileResponse
    from starlette.routing import Mount, Route
    from starlette.staticfiles import StaticFiles

    def read(path: str, give: Callable[[Request], Any]) -> Route:
        return Route(f"/api/{path}", partial(_answered, give), methods=["GET"])

    def write(path: str, do: Callable[[dict[str, Any]], Any]) -> Route:
        async def posted(request: Request) -> Response:
            from starlette.concurrency import run_in_threadpool

            body = await request.body()
            return await run_in_threadpool(_answered, lambda _: do(_content(body)), request)

        return Route(f"/api/{path}", posted, methods=["POST"])

    return Starlette(
        exception_handlers={ClientDisconnect: _broken_off, TimeoutError: _broken_off},
        routes=[
            Route("/", lambda _: FileResponse(STATIC / "index.html"), methods=["GET"]),
            read("state", lambda _: desk.page()),
            read("misfit", lambda request: desk.misfit(count_of(request), place_of(request))),
            read(
                "run",
                lambda request: desk.history(
                    text_of(request, "run"), count_of(request), of=place_of(request)
                ),
            ),
            read("checks", lambda request: desk.checks(place_of(request))),
            read(
                "runs",
                lambda request: desk.runs(count_of(request, "first") or 0, place_of(request)),
            ),
            read("derivatives", lambda request: desk.derivatives(place_of(request))),
            read("missing", lambda _: desk.missing()),
            read("fall", lambda _: desk.fall()),
            read("turns", lambda _: desk.turns()),
            read("trials", lambda _: desk.trials()),
            read("range", lambda _: desk.range()),
            read(
                "settings",
                lambda request: [
                    item.to_dict() for item in desk.action(text_of(request, "of")).fields
                ],
            ),
            Route("/api/frozen", lambda _: _saved(desk), methods=["GET"]),
            write("sail", lambda asked: desk.sail(_settings(desk, asked))),
            write(
                "open",
                lambda asked: desk.open(
                    WorkbenchState(
                        campaign=given_text(asked, "campaign"),
                        also=given_texts(asked, "also"),
                        model=str(asked.get("model") or ""),
                    )
                ).to_dict(),
            ),
            write(
                "beside",
                lambda asked: desk.beside(
                    revision_of(asked), given_text(asked, "campaign")
                ).to_dict(),
            ),
            write(
                "without", lambda asked: desk.without(revision_of(asked), place_in(asked)).to_dict()
            ),
            write("diagnose", lambda asked: desk.diagnose(revision_of(asked)).to_dict()),
            write(
                "add",
                lambda asked: desk.add(
                    revision_of(asked),
                    given_text(asked, "effect"),
                    str(asked.get("why") or ""),
                    str(asked.get("campaign") or ""),
                ).to_dict(),
            ),
            write(
                "check",
                lambda asked: desk.check(given_text(asked, "name"), given_text(asked, "text")),
            ),
            write(
                "write",
                lambda asked: desk.write(
                    revision_of(asked), given_text(asked, "name"), given_text(asked, "text")
                ).to_dict(),
            ),
            write(
                "reduce",
                lambda asked: desk.reduce(
                    given_text(asked, "structure"), place_in(asked)
                ).to_dict(),
            ),
            write("undo", lambda asked: desk.undo(revision_of(asked))),
            write("cancel", lambda _: desk.cancel().to_dict()),
            *data_routes(desk, read, write),
            Mount("/static", StaticFiles(directory=STATIC)),
        ],
    )


def _answered(give: Callable[[Request], Any], request: Request) -> Response:
    """What is asked as JSON; an error in words, with a status that says whose it is."""
    from starlette.responses import JSONResponse

    try:
        return JSONResponse(plain(give(request)))
    except StaleRevision as error:
        return JSONResponse({"error": str(error)}, status_code=409)
    except PmmkitError as error:
        return JSONResponse({"error": str(error)}, status_code=400)
    except Exception as error:
        text = f"{type(error).__name__}: {error}"
        return JSONResponse({"error": text, "unexpected": True}, status_code=500)


def _saved(desk: Desk) -> Response:
    """The page as a file."""
    from starlette.responses import HTMLResponse, PlainTextResponse

    try:
        page = frozen_page(desk)
    except PmmkitError as error:
        return PlainTextResponse(str(error), status_code=400)
    named = {"content-disposition": "attachment; filename=workbench.html"}
    return HTMLResponse(page, headers=named)


def _content(body: bytes) -> dict[str, Any]:
    try:
        found = json.loads(body or b"{}")
    except (ValueError, RecursionError) as error:
        raise DataError("The request holds no JSON.") from error
    if not isinstance(found, dict):
        raise DataError("The request is no JSON object.")
    return found


def _settings(desk: Desk, asked: dict[str, Any]) -> dict[str, Any]:
    """What a manoeuvre may be asked with: its name, a speed, orders and conditions; a band."""
    known = {item.name: item for item in desk.action("simulate").fields}
    for name, value in asked.items():
        item = known.get(name)
        sailed = item is not None and (item.name in ("manoeuvre", "speed") or item.group in ORDERED)
        if name == "band" and isinstance(value, bool):
            continue
        if item is None or not sailed or not item.allows(value):
            raise DataError(f"{name} is no setting of a manoeuvre, or has no such value.")
    if "manoeuvre" not in asked or "speed" not in asked:
        raise DataError("A manoeuvre needs its name and a speed.")
    return asked


# Serving on loopback: a port that is free, a secret address, a browser.


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
        token, printed, opened = (secrets.token_urlsafe(24) for _ in range(3))
        address = f"http://{LOOPBACK}:{number}/?token="
        server = uvicorn.Server(
            uvicorn.Config(
                application(desk, token, number, once=(printed, opened)),
                http=protocol(),
                log_level="warning",
                access_log=False,
                server_header=False,
                ws="none",
                timeout_graceful_shutdown=1,
            )
        )
        say(f"{address}{printed}")
        if desk.job.stand == "idle":
            desk.resume()
        try:
            # Ctrl+C is how it is meant to end.
            with suppress(KeyboardInterrupt), forwarding(desk.folder, f"{address}{opened}") as file:
                if browser and file is not None:
                    webbrowser.open(file.resolve().as_uri())
                server.run(sockets=[channel])
        finally:
            desk.close()


def protocol() -> type:
    """HTTP as uvicorn speaks it, but who does not ask in time is not waited for."""
    from uvicorn.protocols.http.h11_impl import H11Protocol

    class Timed(H11Protocol):
        """Closed where no whole request has come."""

        def connection_made(self, transport: Any) -> None:
            super().connection_made(transport)
            self.loop.call_later(PATIENCE, lambda: None if self.cycle else transport.abort())

    return Timed


@contextmanager
def forwarding(folder: Path, address: str) -> Iterator[Path | None]:
    """A page that only its owner can read and that leads to an address, while that is served.

    The command line of a browser is seen by everybody on the machine, and so it holds no key. In
    the folder of the workbench browsers that are shut in see it, as they do not see hidden ones.
    None where the folder takes no file.
    """
    file, mine = folder / "open.html", not folder.exists()
    text = f'<!doctype html><meta http-equiv="refresh" content="0; url={address}">'
    try:
        folder.mkdir(parents=True, exist_ok=True)
        file.unlink(missing_ok=True)
        with open(os.open(file, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o600), "w") as out:
            out.write(text)
    except OSError:
        yield None
        return
    try:
        yield file
    finally:
        with suppress(OSError):
            file.unlink(missing_ok=True)
            if mine:
                folder.rmdir()


def listening(port: int | None) -> socket.socket:
    """A socket of loopback, at a port or the first that is free."""
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
