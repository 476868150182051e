"""Two struts: what a run states of them, as settings of the motion that they make."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Final

from pmmkit.campaigns.samples.conversions import Frame
from pmmkit.campaigns.settings import Settings
from pmmkit.campaigns.test_kinds.registry import TEST_KINDS
from pmmkit.campaigns.test_kinds.struts import Struts

SWAYS: Final = 0.02
"""Share of the carriage's speed up to which a test counts as pure yaw."""
_KEYS: Final = ("strut_amplitude_m", "strut_phase_deg")


def on_struts(
    test: str, given: Mapping[str, Any], settings: Settings, struts: Struts | None, frame: Frame
) -> tuple[Settings, tuple[str, ...]]:
    """Settings with the motion of two struts, where a run states it, and that in words.

    Without ``strut_phase_deg`` the struts of pure sway go together, and those of pure yaw lead by
    2 atan(ωb/2U), at which the hull follows its heading.
    """
    stated = [name for name in _KEYS if name in given]
    if not stated:
        return settings, ()
    kind = TEST_KINDS[test]
    if not (kind.sways or kind.yaws):
        raise ValueError(f"a {test} test is not made by two struts: leave {stated[0]} out")
    if struts is None:
        raise ValueError("strut_amplitude_m needs the distance of the struts: [struts] spacing")
    if "strut_amplitude_m" not in given:
        raise ValueError("strut_phase_deg needs strut_amplitude_m, the amplitude of each strut")
    omega = settings.omega
    if omega is None:
        raise ValueError("strut_amplitude_m needs the period")
    own = struts.of_pure_yaw(omega, settings.speed) if kind.yaws else 0.0
    phase = own if "strut_phase_deg" not in given else math.radians(given["strut_phase_deg"])
    midway, heading = struts.swing(given["strut_amplitude_m"], phase)
    sideways = abs(midway * omega - settings.speed * math.tan(heading))
    if kind.sways and not kind.yaws and abs(heading) > 0.0:
        raise ValueError(
            f"struts {math.degrees(phase):.4g}° apart turn the hull by "
            f"{math.degrees(heading):.3g}°: a pure_sway test has strut_phase_deg = 0, and this one "
            "is a sway_yaw test"
        )
    if kind.yaws and not kind.sways and sideways > SWAYS * settings.speed:
        raise ValueError(
            f"struts {math.degrees(phase):.4g}° apart let the hull sway by {sideways:.3g} m/s: at "
            f"{settings.speed:g} m/s, T = {settings.period:g} s and {struts.spacing:g} m between "
            f"them yaw alone has strut_phase_deg = {math.degrees(own):.4g}, and this one is a "
            "sway_yaw test"
        )
    # The heading goes by the y of the struts, whichever way their x axis points.
    half = math.pi if frame.motion_sign(test) != frame.sign("y") else 0.0
    both = kind.sways and kind.yaws
    return (
        replace(
            settings,
            amplitude=midway,
            yaw_amplitude=(-heading if both else heading) if kind.yaws else None,
            phase=settings.phase + half,
            strut_spacing=struts.signed,
            strut_centre=struts.centre,
        ),
        (
            f"struts {struts.spacing:g} m apart, the forward one leads by "
            f"{math.degrees(phase):.6g}°: the point midway goes {midway:.6g} m, the heading "
            f"{math.degrees(heading):.6g}°",
        ),
    )
