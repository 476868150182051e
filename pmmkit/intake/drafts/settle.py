"""What the settings of a run are put to: the name's word beside the record's."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from pmmkit.campaigns import TEST_KINDS, setting_key, settings_by_key, ways_to_state
from pmmkit.intake.drafts.motion import Moved
from pmmkit.intake.drafts.names import NameMeaning

_ALSO: Final = ("drift_deg", "rudder_deg", "heel_deg", "phase_deg", "propeller_rps")
_CLOSE: Final = {"speed": 0.03, "period": 0.02, "propeller_rps": 0.03}
"""Relative difference up to which name and record agree; 6 % for others, angles 0.6°."""


@dataclass(frozen=True, kw_only=True)
class RunKey:
    """A key of a run.

    `value`: none where nobody knows. `reason`: where it comes from. `todo`: what a person must
    decide; empty where nothing. `active`: whether the line counts, or is commented out.
    """

    key: str
    value: float | None
    reason: str = ""
    todo: str = ""
    active: bool = True


def asked_of(test: str | None) -> tuple[str, ...]:
    """Keys of a campaign file that describe a test, in the order in which they are written.

    Examples
    --------
    >>> asked_of("yaw_drift"), asked_of("circular_motion"), asked_of(None)
    (('period', 'yaw_amplitude_deg', 'drift_deg'), ('drift_deg', 'yaw_rate'), ())
    """
    if test is None:
        return ()
    kind = TEST_KINDS[test]
    # A free-running record tells by itself what it may take besides.
    names = (*(kind.takes if kind.captive else ()), *kind.needs)
    return tuple(setting_key(name) for name in names)


def settled(
    test: str | None, named: NameMeaning, moved: Moved, *, length: float | None, g: float = 9.81
) -> tuple[RunKey, ...]:
    """The settings of a run from its name and its record.

    length [m]; g [m/s²].
    """
    said = _with_speed(named.settings, length, g)
    if test is not None and TEST_KINDS[test].swings_rudder and "rudder_deg" in said:
        said["rudder_amplitude_deg"] = said.pop("rudder_deg")
    wanted = ("speed", *asked_of(test))
    free = test is not None and TEST_KINDS[test].free_running
    out = [
        _one(key, said, moved.settings, named, said.get("froude"), unsure=free) for key in wanted
    ]
    out += [
        _one(key, said, moved.settings, named, unsure=free)
        for key in _ALSO
        if key not in wanted
        and (key in said or key in moved.settings)
        and abs(said.get(key, moved.settings.get(key, (0.0, "")))[0]) > 0.2
    ]
    return tuple(out)


def _with_speed(
    settings: Mapping[str, tuple[float, str]], length: float | None, g: float
) -> dict[str, tuple[float, str]]:
    """With the speed of a Froude number where the ship is known, the period of a frequency."""
    said = dict(settings)
    if "froude" in said and "speed" not in said and length is not None:
        value, text = said.pop("froude")
        speed = float(f"{value * math.sqrt(g * length):.4g}")
        said["speed"] = (speed, f"{text} and L = {length:g} m")
    if "frequency_hz" in said:
        value, text = said.pop("frequency_hz")
        said.setdefault("period", (float(f"{1 / value:.6g}"), text))
    return said


def _one(
    key: str,
    said: Mapping[str, tuple[float, str]],
    recorded: Mapping[str, tuple[float, str]],
    named: NameMeaning,
    froude: tuple[float, str] | None = None,
    *,
    unsure: bool,
) -> RunKey:
    if key in said and key in recorded:
        value, text = said[key]
        other, where = recorded[key]
        if _agree(key, value, other):
            return RunKey(key=key, value=value, reason=f"{text} in the name; {where}: {other:g}")
        todo = f"the name says {value:g}, the record ({where}) {other:g}: which is right?"
        return RunKey(key=key, value=value, reason=f"{text} in the name", todo=todo)
    if key in said:
        value, text = said[key]
        return RunKey(key=key, value=value, reason=f"{text} in the name")
    if key in recorded:
        value, where = recorded[key]
        return RunKey(key=key, value=value, reason=where, todo="right?" if unsure else "")
    known = settings_by_key().get(key)
    instead, meant = _INSTEAD.get(key, ("", ""))
    if instead in said:
        value, text = said[instead]
        return RunKey(key=instead, value=value, reason=f"{text} in the name: {meant}, in metres")
    hint = next(
        (
            (name, item)
            for name, item in named.hints.items()
            if name in ways_to_state(known.name if known else key)
        ),
        None,
    )
    if hint is not None:
        name, (value, why) = hint
        return RunKey(key=name, value=value, todo=f"{why}; else {key} = ...", active=False)
    todo = (known and known.asked) or key
    if key == "speed" and froude is not None:
        todo += f": Fn = {froude[0]:g} times the root of 9.81 L"
    return RunKey(key=key, value=None, todo=todo, active=False)


_INSTEAD: Final[dict[str, tuple[str, str]]] = {
    "yaw_amplitude_deg": ("path_amplitude_m", "of the path"),
    "yaw_rate": ("radius", "of the circle"),
}
"""What a name may state instead of a key, and what that is."""


def _agree(key: str, value: float, other: float) -> bool:
    if key.endswith("_deg"):
        return abs(value - other) < 0.6 + 0.03 * abs(value)
    return abs(value - other) <= _CLOSE.get(key, 0.06) * abs(value)
