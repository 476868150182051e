"""Settings of a test: from what the campaign file or a table states to SI and our signs."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from typing import Any

from pmmkit.campaigns.run_settings import RUN_SETTINGS, brought, setting_key, ways_to_state
from pmmkit.campaigns.samples.conversions import Frame
from pmmkit.campaigns.settings import Settings
from pmmkit.campaigns.test_kinds.kind import RUDDER
from pmmkit.campaigns.test_kinds.registry import TEST_KINDS


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
    missing = [] if "speed" in given else ["speed"]
    missing += [
        name
        for name in kind.held
        if name != "yaw_rate"
        and setting_key(name) not in given
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
        and not ways_to_state(swing.amplitude) & set(given)
    ]
    words = [RUN_SETTINGS[name].lack for name in missing]
    if kind.sways and kind.yaws and "strut_amplitude_m" in given and "strut_phase_deg" not in given:
        words.append("the lead of the forward strut, strut_phase_deg")
    if kind.circles and "r" not in measured:
        turning = [name for name in ("yaw_rate", "radius") if name in given]
        if not turning:
            words.append(RUN_SETTINGS["yaw_rate"].lack)
        elif len(turning) == 2:
            words.append("only one of yaw_rate and radius, not both")
    return words


def _frequency_known(given: Mapping[str, Any]) -> bool:
    return bool(ways_to_state("period") & set(given)) or any(
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
    speed = float(given["speed"])
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
                (item.name, item.to_si(float(given[item.in_file])))
                for item in brought()
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
