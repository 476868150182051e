"""The addresses of the place Data: files that are dropped, campaign files, windows of records."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from pmmkit.base import DataError, FileExists, PmmkitError
from pmmkit.campaigns import Campaign, CampaignFile, campaign_of, usable
from pmmkit.files import CAMPAIGN, datasets_folder, plain, write_text
from pmmkit.intake import ColumnChoice, DraftAnswers, Drafted
from pmmkit.reduction import PreparedRun
from pmmkit.views import page_of, window_entry
from pmmkit.workbench import incoming
from pmmkit.workbench.desk import Desk

if TYPE_CHECKING:
    from starlette.requests import Request
    from starlette.responses import Response
    from starlette.routing import Route


# What counts of a record, drawn by a person and written into the campaign file with the reason.


REASON: Final = 400
"""Characters of a reason."""


def drawn(
    place: Path, data: str, start: float, end: float, reason: str
) -> Callable[[Campaign, str], None]:
    """Writes a window of a run, in the place of one that was stated for it alone.

    start, end [s].
    """
    said = " ".join(reason.split())
    if not said or len(said) > REASON:
        raise DataError("Say why in a sentence: the reason stands in the campaign file.")
    if not start < end:
        raise DataError("The window ends before it begins.")
    file = _writable(place)

    def write(campaign: Campaign, run: str) -> None:
        entry: dict[str, Any] = {
            **window_entry(campaign, run),
            "t_start": round(start, 6),
            "t_end": round(end, 6),
            "reason": said,
        }
        _write(file, data, run, lambda it: it.with_correction(entry))

    return write


def taken_back(place: Path, data: str) -> Callable[[Campaign, str], None]:
    """Takes the window of a run out of the file: what counts is found again."""
    file = _writable(place)

    def write(campaign: Campaign, run: str) -> None:
        entry = window_entry(campaign, run)
        _write(file, data, run, lambda it: it.without_correction(entry))

    return write


def _write(file: Path, data: str, run: str, change: Callable[[CampaignFile], str]) -> None:
    """The file with the change, where the run can be used with it."""
    try:
        text = change(CampaignFile(file.read_bytes().decode("utf-8")))
    except (OSError, UnicodeDecodeError) as error:
        raise DataError(f"{file} cannot be read: {error}.") from error
    campaign = campaign_of(tomllib.loads(text), file, data=data or None)
    tried = campaign[run]
    if campaign.kind == "captive":
        PreparedRun.of(tried, campaign, noise=False)
    elif not usable(tried).segments:
        raise DataError("Nothing of the record that can be used is left.")
    try:
        write_text(file, text)
    except OSError as error:
        raise FileExists(f"{file} cannot be written: {error.strerror}.") from error


def _writable(place: Path) -> Path:
    file = place / CAMPAIGN.file if place.is_dir() else place
    if file.resolve().is_relative_to(datasets_folder().resolve()):
        raise DataError(
            f"{place} belongs to pmmkit and is not changed. Copy the folder, and open the copy."
        )
    if file.suffix != ".toml":
        raise DataError(
            f"{file.name} is a saved campaign and is not changed. Draft a campaign file for it "
            "(pmmkit new-campaign), and open that."
        )
    return file


# What a request must hold.


LONGEST: Final = 2000
"""Characters of a text in a request."""
MANY: Final = 20
"""Texts in a list of a request."""


def given_text(asked: Mapping[str, Any], name: str) -> str:
    """A text that is not empty."""
    value = asked.get(name)
    if not isinstance(value, str) or not value or len(value) > LONGEST or "\0" in value:
        raise DataError(f"{name} must be a text.")
    return value


def given_texts(asked: Mapping[str, Any], name: str) -> tuple[str, ...]:
    """Texts, none if nothing is given."""
    value = asked.get(name) or []
    if not isinstance(value, list) or len(value) > MANY:
        raise DataError(f"{name} must be a list of at most {MANY} texts.")
    return tuple(given_text({name: item}, name) for item in value)


def revision_of(asked: Mapping[str, Any]) -> int:
    """The state that the page has seen."""
    value = asked.get("revision")
    if not isinstance(value, int) or isinstance(value, bool):
        raise DataError("revision must be a whole number.")
    return value


def place_in(asked: Mapping[str, Any]) -> int:
    """The place of the campaign that is meant, the first if none is named."""
    value = asked.get("of", 0)
    if not isinstance(value, int) or isinstance(value, bool) or value < 0:
        raise DataError("of must be a whole number.")
    return value


def text_of(request: Request, name: str) -> str:
    """A text of the address that is not empty."""
    return given_text(dict(request.query_params), name)


def count_of(request: Request, name: str = "count") -> int | None:
    """A whole number of the address; None where there is none."""
    given = request.query_params.get(name)
    if given is None:
        return None
    if not given.isascii() or not given.isdigit() or len(given) > 6:
        raise DataError(f"{name} must be a whole number.")
    return int(given)


def place_of(request: Request) -> int:
    """The place of the campaign that an address means, the first if none is named."""
    return count_of(request, "of") or 0


def given_number(asked: Mapping[str, Any], name: str) -> float:
    """A finite number."""
    value = asked.get(name)
    if not isinstance(value, int | float) or isinstance(value, bool) or not math.isfinite(value):
        raise DataError(f"{name} must be a number.")
    return float(value)


MOST: Final = 20_000
"""Choices and answers of a request."""


def data_routes(
    desk: Desk,
    read: Callable[[str, Callable[[Request], Any]], Route],
    write: Callable[[str, Callable[[dict[str, Any]], Any]], Route],
) -> list[Route]:
    """What the place Data asks and does."""
    from starlette.routing import Route

    return [
        read("record", lambda request: desk.record(text_of(request, "run"), place_of(request))),
        read("incoming", lambda _: incoming.sets(desk.folder)),
        write("look", lambda asked: page_of(_drafted(desk, _asked(desk, asked)))),
        write("campaign", partial(_campaign, desk)),
        write("window", partial(_window, desk)),
        write("unwindow", partial(_unwindow, desk)),
        write("again", lambda asked: desk.again(revision_of(asked), _parts_in(asked)).to_dict()),
        Route("/api/drop", partial(_drop, desk), methods=["POST"]),
    ]


def _parts_in(asked: Mapping[str, Any]) -> str | None:
    """Who is to lend propeller and rudder; None for who does already."""
    return str(asked["parts"]) if "parts" in asked else None


async def _drop(desk: Desk, request: Request) -> Response:
    """One file more for a set, or for a new one."""
    from starlette.responses import JSONResponse

    try:
        place = incoming.place_of(desk.folder, request.query_params.get("into", ""))
        name = request.query_params.get("name", "")
        size = await incoming.keep(place, name, request.stream())
    except PmmkitError as error:
        return JSONResponse({"error": str(error)}, status_code=400)
    except OSError as error:
        return JSONResponse({"error": f"It cannot be kept: {error.strerror}."}, status_code=400)
    answer = {"into": place.name, "folder": str(place), "name": name, "size": size}
    return JSONResponse(plain(answer))


def _campaign(desk: Desk, asked: Mapping[str, Any]) -> dict[str, Any]:
    """Write the campaign file that is proposed."""
    said = _asked(desk, asked)
    if not any(said.folder.is_relative_to(root) for root in (*desk.roots, desk.folder.resolve())):
        raise DataError(f"{said.folder} belongs to pmmkit: nothing is written there.")
    found = _drafted(desk, said)
    wrong = [item for item in found.fields if item.error]
    if wrong:
        return {**page_of(found), "written": ""}
    with desk.writing():
        if found.new and said.target.exists():
            raise DataError(f"{said.target} is there meanwhile: it was not replaced. Look again.")
        write_text(said.target, found.text)
    after = _drafted(desk, DraftAnswers(folder=said.folder))
    return {**page_of(after), "written": str(said.target)}


def _drafted(desk: Desk, said: DraftAnswers) -> Drafted:
    """What is proposed; the files are looked at once for all answers."""
    basis = desk.known.once(("basis", said.stamp), said.basis)
    return said.drafted(basis)


def _window(desk: Desk, asked: Mapping[str, Any]) -> None:
    start, end = (given_number(asked, name) for name in ("t_start", "t_end"))
    of = place_in(asked)
    place, data = desk.opened_at(of)
    write = drawn(place, data, start, end, given_text(asked, "reason"))
    desk.correct(revision_of(asked), given_text(asked, "run"), write, of)


def _unwindow(desk: Desk, asked: Mapping[str, Any]) -> None:
    of = place_in(asked)
    place, data = desk.opened_at(of)
    desk.correct(revision_of(asked), given_text(asked, "run"), taken_back(place, data), of)


def _asked(desk: Desk, asked: Mapping[str, Any]) -> DraftAnswers:
    folder = desk.named(given_text(asked, "folder"))
    if not folder.is_dir():
        raise DataError(f"{folder} is no folder. Name the folder in which the files lie.")
    answers = asked.get("answers", {})
    listed = asked.get("choices", [])
    if not isinstance(answers, dict) or not isinstance(listed, list):
        raise DataError("answers must be a table, and choices a list.")
    if len(answers) + len(listed) > MOST:
        raise DataError(f"More than {MOST} answers at once are not taken.")
    said = {
        name: value
        for name, value in answers.items()
        if isinstance(value, str) and len(value) <= incoming.LONGEST
    }
    ship = asked.get("ship", "")
    return DraftAnswers(
        folder=Path(folder),
        choices=tuple(_choice(item) for item in listed),
        ship=ship if isinstance(ship, str) else "",
        answers=said,
    )


def _choice(item: Any) -> ColumnChoice:
    if not isinstance(item, dict):
        raise DataError("A choice must be a table.")
    column, sign, unit = item.get("column"), item.get("sign"), item.get("unit") or None
    name = item.get("name", "")
    whole = isinstance(column, int) and not isinstance(column, bool) and sign in (None, 1, -1)
    if not whole or not isinstance(name, str) or not isinstance(unit, str | None):
        raise DataError("A choice has a file, a column, a name, and perhaps a unit and a sign.")
    file = given_text(item, "file")
    return ColumnChoice(file=file, column=column or 0, name=name, unit=unit, sign=sign)
