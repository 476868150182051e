"""The addresses of the server and what each gives."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import partial
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from pmmkit.errors import DataError, PmmkitError
from pmmkit.json_text import plain
from pmmkit.workbench.asked import (
    count_of,
    given_text,
    given_texts,
    place_in,
    place_of,
    revision_of,
    text_of,
)
from pmmkit.workbench.data_routes import data_routes
from pmmkit.workbench.desk import Desk, StaleRevision
from pmmkit.workbench.frozen import frozen_page
from pmmkit.workbench.guard import Guard
from pmmkit.workbench.saved import State

if TYPE_CHECKING:
    from starlette.applications import Starlette
    from starlette.requests import Request
    from starlette.responses import Response

STATIC: Final = Path(str(files("pmmkit.workbench"))) / "static"
SAILED: Final = {
    "manoeuvre": str,
    "speed": float,
    "rudder_deg": float,
    "switch_deg": float,
    "wind_speed": float,
    "wind_direction_deg": float,
    "depth": float,
    "band": bool,
}
"""What a manoeuvre may be asked with."""


def application(desk: Desk, token: str, port: int) -> Guard:
    """The guarded application.

    Parameters
    ----------
    desk : Desk
        What the server holds.
    token : str
        The secret of its address.
    port : int
        On loopback.
    """
    return Guard(app=_routes(desk), token=token, port=port)


def _routes(desk: Desk) -> Starlette:
    from starlette.applications import Starlette
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
            Route("/api/frozen", lambda _: _saved(desk), methods=["GET"]),
            write("sail", lambda asked: desk.sail(_settings(asked))),
            write(
                "open",
                lambda asked: desk.open(
                    State(
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
        ]
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


def _settings(asked: dict[str, Any]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name, value in asked.items():
        kind = SAILED.get(name)
        right = isinstance(value, kind or str) if kind is not float else _number(value)
        if kind is None or not right:
            raise DataError(f"{name} is no setting of a manoeuvre, or has no such value.")
        found[name] = value
    if "manoeuvre" not in found or "speed" not in found:
        raise DataError("A manoeuvre needs its name and a speed.")
    return found


def _number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)
