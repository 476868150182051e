"""Settings of a test: from what the campaign file or a table states to SI and our signs."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any, Final

from pmmkit.campaigns.file.schema import DefaultsEntry, read_entry
from pmmkit.campaigns.file.single_tables import Faults
from pmmkit.campaigns.run_settings import RUN_SETTINGS
from pmmkit.campaigns.samples.conversions import Frame
from pmmkit.campaigns.setting import ANY
from pmmkit.campaigns.settings import Settings
from pmmkit.campaigns.test_kinds.kind import RUDDER, TEST_KINDS, TestKind

# What runs have in common, stated once: ``[defaults]`` and a table of it for a kind of test.


_NESTED: Final = ("source", "columns", "cfd")
_NO_KINDS: Final = (*_NESTED, "tare")


@dataclass(frozen=True, kw_only=True)
class Defaults:
    """Keys of runs that state nothing else.

    `every`: for runs of all kinds. `of_kind`: for runs of one kind, before those for all.
    """

    every: Mapping[str, Any] = field(default_factory=dict)
    of_kind: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)


def read_defaults(raw: Any, out: Faults) -> Defaults:
    """``[defaults]``, validated; keys that are wrong are left out and added to `out`."""
    if not isinstance(raw, Mapping):
        out.report("must be a table.", "[defaults]")
        return Defaults()
    tables = {
        name: item
        for name, item in raw.items()
        if isinstance(item, Mapping) and name not in _NO_KINDS
    }
    for name in tables:
        if name not in TEST_KINDS:
            out.report(TEST_KINDS.unknown(name), f"[defaults.{name}]")
    return Defaults(
        every=_valid(
            {name: item for name, item in raw.items() if name not in tables}, "[defaults]", out
        ),
        of_kind={
            name: _valid(item, f"[defaults.{name}]", out)
            for name, item in tables.items()
            if name in TEST_KINDS
        },
    )


def _valid(raw: Mapping[str, Any], entry: str, out: Faults) -> dict[str, Any]:
    return {
        name: item
        for name, item in raw.items()
        if read_entry(DefaultsEntry, {name: item}, entry, out)
    }


def with_defaults(
    raw: Any, defaults: Defaults, mapped: Collection[str] = (), *, histories: bool = True
) -> Any:
    """An entry of ``[[runs]]``, ``[[tables]]`` or ``[[matrix]]`` with what it does not state.

    What a run states counts before what its kind has by default, and that before what all have;
    ``source``, ``columns`` and ``cfd`` are completed key by key. Of what all have a run takes only
    what its kind of test uses.

    Examples
    --------
    >>> common = Defaults(every={"speed": 1.5, "period": 9.0},
    ...                   of_kind={"pure_yaw": {"period": 12.0}})
    >>> with_defaults({"test": "pure_yaw"}, common)
    {'test': 'pure_yaw', 'period': 12.0, 'speed': 1.5}
    >>> with_defaults({"test": "static_drift", "speed": 1.0}, common)
    {'test': 'static_drift', 'speed': 1.0}
    >>> with_defaults({"test": "pure_sway", "frequency_hz": 0.1}, common)
    {'test': 'pure_sway', 'frequency_hz': 0.1, 'speed': 1.5}
    """
    test = raw.get("test") if isinstance(raw, Mapping) else None
    if not isinstance(test, str) or test not in TEST_KINDS:
        return raw
    kind = TEST_KINDS[test]
    found = dict(raw)
    if kind.at_rest and found.get("speed") == 0:
        del found["speed"]
    rows = "row" in raw or not histories or kind.at_rest
    used = {name: item for name, item in defaults.every.items() if _uses(kind, name)}
    for common in (defaults.of_kind.get(test, {}), used):
        stated = {*found, *mapped}
        for name, item in common.items():
            if name == "tare" and rows:
                continue
            if name in _NESTED:
                own = found.get(name, {})
                found[name] = {**item, **own} if isinstance(own, Mapping) else own
            elif name not in found and not _others(name) & stated:
                found[name] = item
    return found


def _others(name: str) -> frozenset[str]:
    """Settings of which one stands for the others: a run that states one takes none by default."""
    item = RUN_SETTINGS.by_key.get(name)
    if item is None:
        return frozenset()
    ways = (RUN_SETTINGS.ways_to_state(stated) for stated in (item.name, *item.states))
    return frozenset().union(*ways) - {name}


def _uses(kind: TestKind, name: str) -> bool:
    """Whether a setting means anything in tests of a kind."""
    item = RUN_SETTINGS.by_key.get(name)
    if item is None:
        return True
    if kind.at_rest and name == "speed":
        return False
    if item.of_swing == ANY:
        return kind.oscillates
    swung = {swing.velocity or swing.displacement for swing in kind.swings}
    if kind.circles and "yaw_rate" in item.states:
        return True
    if item.of_swing:
        return bool(swung & set(item.of_swing)) and not swung & set(item.without)
    needed = {item.name, *item.states} & {*kind.needs, *kind.takes}
    return bool(needed) or not item.where_needed


def missing_settings(
    test: str, given: Mapping[str, Any], measured: Collection[str] = ()
) -> list[str]:
    """What a test of that kind still needs, in words.

    Examples
    --------
    >>> missing_settings("pure_sway", {"speed": 1.0, "period": 12.5})
    ['the amplitude, amplitude_m']
    >>> missing_settings("pure_sway", {"speed": 1.0}, measured={"v"})
    []
    >>> missing_settings("pure_sway", {"speed": 1.0, "period": 12.5}, measured={"y", "psi"})
    []
    """
    kind = TEST_KINDS[test]
    if kind.at_rest:
        return _missing_at_rest(kind, given)
    missing = [] if "speed" in given else ["speed"]
    missing += [
        name
        for name in kind.held
        if name != "yaw_rate"
        and RUN_SETTINGS.key_of(name) not in given
        and RUN_SETTINGS[name].measured_by not in measured
    ]
    swings = [swing for swing in kind.swings if swing.velocity not in measured]
    if swings and not _frequency_known(given):
        missing.append("period")
    missing += [
        swing.amplitude
        for swing in swings
        # That of a rudder decides which derivatives are asked for, before a record is read.
        if (swing is RUDDER or not kind.places <= set(measured))
        and not RUN_SETTINGS.ways_to_state(swing.amplitude) & set(given)
    ]
    words = [RUN_SETTINGS[name].lack for name in missing]
    if kind.sways and kind.yaws and "strut_amplitude_m" in given and "strut_phase_deg" not in given:
        words.append("the lead of the forward strut, strut_phase_deg")
    if swings and given.get("r_amplitude") == 0.0:
        words.append("an amplitude: r_amplitude is 0")
    if kind.circles and "r" not in measured:
        turning = [name for name in ("yaw_rate", "radius", "r_amplitude") if name in given]
        if not turning:
            words.append(RUN_SETTINGS["yaw_rate"].lack)
        elif len(turning) > 1:
            words.append(f"only one of {' and '.join(turning)}")
    return words


def _missing_at_rest(kind: TestKind, given: Mapping[str, Any]) -> list[str]:
    """What a check of the balance still needs: no speed, and a load that is known."""
    if "speed" in given:
        return ["a carriage that stands: leave speed out"]
    loads = [name for name in kind.takes if RUN_SETTINGS[name].along]
    known = any(RUN_SETTINGS.key_of(name) in given for name in loads)
    return [] if known else [f"a load that is known (0 too): {', '.join(loads)}"]


def _frequency_known(given: Mapping[str, Any]) -> bool:
    return bool(RUN_SETTINGS.ways_to_state("period") & set(given)) or any(
        {top, bottom} <= set(given)
        for top, bottom in (("rdot_amplitude", "r_amplitude"), ("vdot_amplitude", "v_amplitude"))
    )


def settings_of(
    test: str, given: Mapping[str, Any], frame: Frame, length: float, *, turn_phase: bool = True
) -> tuple[Settings, tuple[str, ...]]:
    """Settings in SI and our signs, and the conversions in words.

    The angular frequency is 2π ``frequency_hz``, else 2π/``period``, else the ratio of the primed
    amplitudes times U/L. Amplitudes that are not stated come from the primed ones: of the
    displacement |v̇'| U²/(L ω²) or |v'| U/ω, of the heading |r'| U/(L ω) or |ṙ'| U²/(L² ω²). A pure
    yaw test that is set by the amplitude a of its path has the heading along that path:
    tan ψ0 = aω/U.

    length [m].
    """
    notes: list[str] = []
    speed = 0.0 if TEST_KINDS[test].at_rest else float(given["speed"])
    period = _period(given, speed / length, notes)
    amplitude = given.get("amplitude_m")
    yaw = _radians(given, "yaw_amplitude_deg")
    if period is not None:
        omega = 2 * math.pi / period
        if amplitude is None and "vdot_amplitude" in given:
            amplitude = abs(given["vdot_amplitude"]) * speed**2 / (length * omega**2)
            notes.append("amplitude from the primed acceleration: |vdot'| U²/(L ω²)")
        elif amplitude is None and "v_amplitude" in given:
            amplitude = abs(given["v_amplitude"]) * speed / omega
            notes.append("amplitude from the primed velocity: |v'| U/ω")
        if yaw is None and "path_amplitude_m" in given and not TEST_KINDS[test].sways:
            yaw = math.atan(given["path_amplitude_m"] * omega / speed)
            notes.append("yaw amplitude from that of the path: atan(a ω/U)")
        elif yaw is None and "r_amplitude" in given:
            yaw = abs(given["r_amplitude"]) * speed / length / omega
            notes.append("yaw amplitude from the primed yaw rate: |r'| U/(L ω)")
        elif yaw is None and "rdot_amplitude" in given:
            yaw = abs(given["rdot_amplitude"]) * (speed / length / omega) ** 2
            notes.append("yaw amplitude from the primed yaw acceleration: |rdot'| U²/(L² ω²)")
    phase = _radians(given, "phase_deg") or 0.0
    if turn_phase and frame.motion_sign(test) < 0:
        phase += math.pi
        notes.append("phase of the motion turned by 180° because the axis points the other way")
    kind = TEST_KINDS[test]
    if yaw is not None and kind.sways and kind.yaws and frame.sign("r") != frame.sign("v"):
        yaw = -yaw
    drift, rudder = _radians(given, "drift_deg") or 0.0, _radians(given, "rudder_deg") or 0.0
    if frame.drift_sign < 0 and drift:
        drift = -drift
        whence = "positive with the bow to port" if frame.drift_positive else "along their axes"
        notes.append(f"drift angle: stated {whence}, sign changed")
    if frame.rudder_to_port and rudder:
        rudder = -rudder
        notes.append("rudder angle: stated positive to port, sign changed")
    turning: dict[str, Any] = {name: given.get(name) for name in ("yaw_rate", "radius")}
    if kind.circles and "r_amplitude" in given:
        turning["yaw_rate"] = given["r_amplitude"] * speed / length
        notes.append("yaw rate from the primed one: r' U/L")
    if frame.sign("r") < 0 and any(turning.values()):
        turning = {name: value and -value for name, value in turning.items()}
        notes.append("turn: stated along their axes, sign changed")
    heel = _radians(given, "heel_deg") or 0.0
    if frame.sign("phi") < 0 and heel:
        heel = -heel
        notes.append("heel: stated along their axes, sign changed")
    return (
        Settings(
            speed=speed,
            drift=drift,
            heel=heel,
            rudder=rudder,
            propeller_rps=given.get("propeller_rps"),
            period=period,
            amplitude=amplitude,
            yaw_amplitude=yaw,
            rudder_amplitude=_radians(given, "rudder_amplitude_deg"),
            phase=phase,
            **turning,
            depth=given.get("depth"),
            switch=_radians(given, "switch_deg"),
            wave_height=given.get("wave_height"),
            wave_period=given.get("wave_period"),
            waves_from=_radians(given, "waves_from_deg"),
            repeat_of=given.get("repeat_of"),
            further=tuple(
                (item.name, frame.sign(item.along) * item.to_si(float(given[item.in_file])))
                for item in RUN_SETTINGS.brought
                if item.in_file in given
            ),
        ),
        tuple(notes),
    )


def _period(given: Mapping[str, Any], rate: float, notes: list[str]) -> float | None:
    if "frequency_hz" in given:
        notes.append("period from the frequency in Hz")
        return 1.0 / float(given["frequency_hz"])
    if "period" in given:
        return float(given["period"])
    for top, bottom in (("rdot_amplitude", "r_amplitude"), ("vdot_amplitude", "v_amplitude")):
        if top in given and bottom in given:
            notes.append(f"period from the primed amplitudes: ω = |{top}/{bottom}| U/L")
            return 2 * math.pi / (abs(float(given[top]) / float(given[bottom])) * rate)
    return None


def _radians(given: Mapping[str, Any], name: str) -> float | None:
    return None if name not in given else math.radians(given[name])
