"""Files of a plan: limits of tank and rig and runs to choose from; runs for a campaign file."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Final

from pmmkit.base import CampaignError, Problem
from pmmkit.campaigns import RUN_SETTINGS, TEST_KINDS, RunSetting, Settings
from pmmkit.conventions import Ship
from pmmkit.diagnosis.planning.options import Limits, Option, timed
from pmmkit.files import check_numbers, toml_string

LIMITS: Final = {
    "speeds": ("speeds", 1.0),
    "drift_deg": ("drift", math.pi / 180),
    "rudder_deg": ("rudder", math.pi / 180),
    "heel_deg": ("heel", math.pi / 180),
    "sway_m": ("sway", 1.0),
    "yaw_deg": ("yaw", math.pi / 180),
    "sway_velocity": ("sway_velocity", 1.0),
    "yaw_rate": ("yaw_rate", 1.0),
    "frequencies": ("frequencies", 1.0),
    "tests": ("tests", None),
    "cycles": ("cycles", None),
    "tank_length": ("tank_length", 1.0),
    "tank_width": ("tank_width", 1.0),
    "wait_min": ("wait", 60.0),
    "propeller_rps": ("propeller_rps", 1.0),
}
"""Keys of ``[limits]``: the limit and its unit."""
_LISTS: Final = ("speeds", "frequencies", "tests")
_UNLISTED: Final = ("phase", "switch")
"""Settings that no captive run to choose from needs to state."""
_NAMES: Final = ("id", "file", "test", "repeat_of")


def read_plan_file(
    path: str | Path, ship: Ship, limits: Limits | None = None
) -> tuple[Limits, tuple[Option, ...] | None]:
    """Limits and runs from a TOML file.

    Parameters
    ----------
    path : path
        With a table ``[limits]`` (speeds, drift_deg, rudder_deg, heel_deg, sway_m, yaw_deg,
        sway_velocity, yaw_rate, frequencies, tests, cycles, tank_length, tank_width, wait_min,
        propeller_rps), or ``[[runs]]`` as in a campaign file, or both.
    ship : Ship
        Of the model.
    limits : Limits, optional
        What counts where the file says nothing.

    Returns
    -------
    Limits, tuple of Option or None
        Without ``[[runs]]`` no options: all within the limits are offered.

    Raises
    ------
    CampaignError
        With everything that is wrong with the file.
    """
    place = Path(path)
    try:
        raw = tomllib.loads(place.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise CampaignError(Problem(message=f"is not TOML: {error}.", file=str(place))) from error
    check_numbers(raw, str(place), CampaignError)
    wrong = [
        Problem(
            message="not known; a plan file has [limits] and [[runs]].",
            file=str(place),
            entry=f"[{name}]",
        )
        for name in raw
        if name not in ("limits", "runs")
    ]
    given, entries = raw.get("limits", {}), raw.get("runs", [])
    if not isinstance(given, dict) or not isinstance(entries, list):
        raise CampaignError(
            Problem(message="[limits] is a table, [[runs]] a list of tables.", file=str(place))
        )
    speeds = [x["speed"] for x in entries if isinstance(x, dict) and _number(x.get("speed"))]
    start = limits or Limits(speeds=tuple(sorted({float(x) for x in speeds})) or (1.0,))
    try:
        if limits is None and not speeds and "speeds" not in given:
            raise CampaignError("speeds are missing.")
        start = _limits(given, start)
    except CampaignError as error:
        wrong += [
            Problem(message=item.message, file=str(place), entry="[limits]")
            for item in error.problems
        ]
    found = []
    for number, entry in enumerate(entries, start=1):
        try:
            found.append(_listed(entry, start, ship))
        except CampaignError as error:
            wrong += [
                Problem(message=item.message, file=str(place), entry=f"[[runs]] #{number}")
                for item in error.problems
            ]
    if wrong:
        raise CampaignError(wrong, title=f"{place} cannot be used")
    return start, tuple(found) or None


def _number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _limits(given: Mapping[str, Any], start: Limits) -> Limits:
    wrong, changes = [], dict[str, Any]()
    for name, value in given.items():
        if name not in LIMITS:
            wrong.append(f"{name!r} is no limit: {', '.join(LIMITS)}.")
            continue
        limit, unit = LIMITS[name]
        kind = str if name == "tests" else (int, float)
        values = value if name in _LISTS else [value]
        good = isinstance(values, list) and all(
            isinstance(x, kind) and not isinstance(x, bool) for x in values
        )
        if not good or (name == "cycles" and not isinstance(value, int)):
            wrong.append(f"{name} = {value!r} is not what it must be: {_kind(name)}.")
            continue
        scaled = tuple(values) if unit is None else tuple(unit * float(x) for x in values)
        changes[limit] = scaled if name in _LISTS else scaled[0]
    if wrong:
        raise CampaignError(wrong)
    return start.with_(**changes)


def _kind(name: str) -> str:
    if name == "tests":
        return "a list of texts"
    if name in _LISTS:
        return "a list of numbers"
    return "a whole number" if name == "cycles" else "a number"


def _plannable() -> dict[str, RunSetting]:
    """Settings that a run to choose from may state, by key: angles first."""
    first = ("drift", "heel", "rudder", "yaw_amplitude", "rudder_amplitude", "speed", "period")
    ordered = RUN_SETTINGS.ordered(*first, "amplitude")
    return {
        item.in_file: item
        for item in ordered
        if item.kept and not item.surroundings and item.name not in _UNLISTED
    }


def _listed(entry: Any, limits: Limits, ship: Ship) -> Option:
    if not isinstance(entry, dict):
        raise CampaignError("is no table.")
    keys = _plannable()
    allowed = (*keys, *_NAMES)
    test = entry.get("test")
    wrong = [
        f"{name!r} is no setting of a run: {', '.join(allowed)}."
        for name in entry
        if name not in allowed
    ]
    if test not in [kind.name for kind in TEST_KINDS.values() if kind.captive and not kind.at_rest]:
        wrong.append(f"test = {test!r} is no captive test.")
    wrong += [
        f"{name} = {entry[name]!r} is no number."
        for name in keys
        if name in entry and not _number(entry[name])
    ]
    if not wrong and not entry.get("speed", 0.0) > 0:
        wrong.append("speed must be there, and positive.")
    if wrong:
        raise CampaignError(wrong)
    given = {keys[key].name: keys[key].to_si(float(entry[key])) for key in keys if key in entry}
    settings = Settings.of(given)
    known = Option(test=str(test), settings=settings, cycles=0, record=0.0, hours=0.0)
    known.run().require_settings()
    option = timed(str(test), settings, limits, ship)
    if option is None:
        raise CampaignError("the tank is too short for three cycles.")
    return option


def entries_text(options: Iterable[Option]) -> str:
    """Options as ``[[runs]]`` that can be pasted into a campaign file.

    Examples
    --------
    >>> from pmmkit.models import load_ship
    >>> limits = Limits(speeds=(1.5,))
    >>> option = timed("static_drift", Settings(speed=1.5, drift=0.1), limits, load_ship("s175"))
    >>> print(entries_text([option]), end="")
    [[runs]]
    id = "SD_1.5_b+5.73"
    test = "static_drift"
    file = "runs/SD_1.5_b+5.73.csv"
    speed = 1.5
    drift_deg = 5.7296
    """
    blocks = []
    for entry in entries_of(options):
        lines = [
            f"{key} = {toml_string(x)}" if isinstance(x, str) else f"{key} = {x}"
            for key, x in entry.items()
        ]
        blocks.append("\n".join(["[[runs]]", *lines]) + "\n")
    return "\n".join(blocks)


def entries_of(options: Iterable[Option]) -> list[dict[str, Any]]:
    """Options as entries of a campaign file, those that are there again as repeats of the first."""
    found, seen = [], dict[str, int]()
    for option in options:
        entry = option.entry
        times = seen[option.id] = seen.get(option.id, 0) + 1
        if times > 1:
            first, name = entry["id"], f"{entry['id']}_{times}"
            entry |= {"id": name, "file": f"runs/{name}.csv", "repeat_of": first}
        found.append(entry)
    return found
