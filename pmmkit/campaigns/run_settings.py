"""The settings of a run: all that anybody asks of each, declared once."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import Final

from pmmkit.base import Registry
from pmmkit.campaigns.setting import (
    ANGLE,
    ANY,
    LENGTH,
    NOT_ZERO,
    POSITIVE,
    RATE,
    SEA,
    SPEED,
    STEEP,
    SWING,
    TURN,
    Bounds,
    Resolution,
    RunSetting,
    Sensor,
    Told,
)
from pmmkit.conventions import CHANNEL_UNITS, FORCE_CHANNELS, harmonic_part, unit_in_name

GROUP: Final = "pmmkit.run_settings"
"""Entry points by which other packages bring the settings that their kinds of test need."""

_OURS: Final = (
    RunSetting(
        name="speed",
        unit="m/s",
        meaning="of the carriage, or of the approach [m/s]",
        bounds=Bounds(least=0.01, most=50),
        place=0,
        word="speed",
        head="Speed",
        stated_std=True,
        missing="the carriage speed, speed [m/s]",
        asked="speed of the carriage, or of the approach [m/s]",
        resolution=SPEED,
        in_names=(
            (r"(?:U|Uc|Uo|U0|[Ss]peed|[Vv]el|V(?=\d+[.,p]\d))#(?:m/s|ms|mps)?", 1.0),
            (r"V?#(?:mps|ms|m/s)", 1.0),
            (r"[VvUu]?#(?:kn|kts|knots)", 1852 / 3600),
            (r"[VvUu]?#(?:fps|ft/s)", 0.3048),
        ),
        header="speed(?: m s)?|[vu] ?[0o]?|(?:towing )?carriage speed|towing speed|v ?carriage"
        "|u ?c",
        sensors=(
            Sensor(
                column="hull speed",
                allowed=0.005,
                share=0.02,
                remedy="Correct speed of these runs, or the units of u and v.",
            ),
            Sensor(
                column="x over time",
                allowed=0.005,
                share=0.02,
                remedy="Look at the period (of a cycle without times), at the clock and at the "
                "unit of x: the motion is taken from x.",
            ),
        ),
    ),
    RunSetting(
        name="drift",
        key="drift_deg",
        unit="deg",
        meaning="drift angle, signed as `drift_positive` says",
        bounds=TURN,
        place=1,
        told=Told(symbol="β", word="drift", unit="°", form="+.3g"),
        word="drift angle",
        head="β",
        zero_error="alignment",
        stated_std=True,
        asked="drift angle [deg], positive with the bow to starboard of the track",
        resolution=ANGLE,
        in_names=((r"(?:[Bb]eta|BETA|[Dd]rift|DRIFT|β|b)#(?:deg|d|°)?", 1.0),),
        header="beta|β|drift(?: angle)?",
        measured_by="v",
        sensors=(
            Sensor(
                column="psi",
                allowed=math.radians(0.5),
                remedy="One of them is wrong: look at the name of the test. If the heading is "
                "right, take the drift from it in the table of these runs, columns = { drift_deg = "
                "their heading, psi = false, speed = their u, u = false, v = false }; else set "
                "drift_deg, or leave these runs out.",
            ),
        ),
        code="b",
        typical=0.15,
    ),
    RunSetting(
        name="heel",
        key="heel_deg",
        unit="deg",
        meaning="heel, positive to starboard",
        bounds=STEEP,
        place=3,
        told=Told(symbol="heel", word="heel", unit="°", form="+.3g"),
        word="heel",
        head="Heel",
        zero_error="zero",
        stated_std=True,
        asked="heel [deg]",
        resolution=ANGLE,
        in_names=((r"(?:[Hh]eel|[Pp]hi|φ)#(?:deg|°)?", 1.0),),
        header="phi|φ|heel(?: angle)?",
        measured_by="phi",
        code="h",
        typical=0.1,
    ),
    RunSetting(
        name="rudder",
        key="rudder_deg",
        unit="deg",
        meaning="rudder angle, signed as `rudder_positive` says",
        bounds=TURN,
        place=2,
        told=Told(symbol="δ", word="rudder", unit="°", form="+.3g"),
        word="rudder angle",
        head="δ",
        zero_error="zero",
        stated_std=True,
        asked="rudder angle [deg]",
        resolution=ANGLE,
        in_names=(
            (r"(?:[Dd]elta|DELTA|[Rr]udder|RUDDER|[Rr]ud|δ)#(?:deg|°)?", 1.0),
            (r"d(?=[+-])#(?:deg|°)?", 1.0),
        ),
        header="delta|δ|rudder(?: angle)?",
        measured_by="delta",
        sensors=(
            Sensor(
                column="delta",
                allowed=math.radians(1.5),
                share=0.05,
                remedy="A rudder that moves lags behind its order: set rudder_deg from the "
                "measured column. Else look at its zero and its unit.",
            ),
        ),
        code="d",
        typical=0.3,
    ),
    RunSetting(
        name="propeller_rps",
        unit="1/s",
        meaning="revolutions [1/s]",
        place=10,
        told=Told(symbol="n", word="propeller", unit="/s", form=".4g"),
        word="propeller",
        title="revolutions",
        head="n",
        stated_std=True,
        resolution=RATE,
        in_names=((r"(?:n|N|rps)?#rps|rps#", 1.0), (r"(?:n|N|rpm)?#rpm|rpm#", 1 / 60)),
        header="rps|rpm|n|prop(?:eller)? (?:rps|rev(?:olution)?s?|given|ordered|nominal)",
        sensors=(
            Sensor(
                column="n",
                allowed=0.05,
                share=0.03,
                remedy="Look at the unit of the revolutions, or which of the two was held.",
            ),
        ),
    ),
    RunSetting(
        name="period",
        unit="s",
        meaning="of an oscillation [s]",
        bounds=Bounds(least=0.05, most=600),
        of_swing=ANY,
        place=7,
        told=Told(symbol="T", word="period", unit=" s", form=".4g"),
        word="period",
        head="Period",
        stated_std=True,
        missing="the period [s] (or frequency_hz)",
        asked="period [s]",
        resolution=RATE,
        in_names=((r"(?:T|Tp|[Pp]eriod|[Pp]er)#(?:s|sec)?", 1.0),),
        header="period",
        code="T",
        typical=8.0,
    ),
    RunSetting(
        name="frequency_hz",
        unit="1/s",
        meaning="its inverse [Hz]",
        bounds=Bounds(least=1 / 600, most=20),
        kept=False,
        states=("period",),
        of_swing=ANY,
        in_names=(
            (r"(?:f|F|[Ff]req)?#(?:Hz|hz|HZ)", 1.0),
            (r"(?:w|om|omega|ω)(?=\d*[.,]\d)#(?:rads?|rad/s)?", 1 / (2 * math.pi)),
        ),
        header="freq|frequency|f",
    ),
    RunSetting(
        name="amplitude",
        key="amplitude_m",
        unit="m",
        meaning="of surge or sway [m]",
        bounds=POSITIVE,
        of_swing=("u", "v"),
        place=4,
        told=Told(symbol="a", word="sway", unit=" m", form=".4g"),
        word="amplitude",
        title="amplitude of surge or sway",
        head="Amplitude",
        stated_std=True,
        asked="amplitude of the displacement [m]",
        resolution=LENGTH,
        in_names=tuple(
            (rf"(?:a|A|[Aa]mp|y|ya)#{unit}", factor)
            for unit, factor in (("m?", 1.0), ("mm", 1e-3), ("ft", 0.3048), ("in", 0.0254))
        ),
        header="(?:sway |motion |y )?ampl?(?:itude)?|y ?[a0]",
        code="a",
        typical=0.3,
    ),
    RunSetting(
        name="yaw_amplitude",
        key="yaw_amplitude_deg",
        unit="deg",
        meaning="of the heading",
        bounds=SWING,
        of_swing=("r",),
        place=5,
        told=Told(symbol="ψ", word="yaw", unit="°", form=".3g"),
        word="yaw amplitude",
        title="amplitude of yaw",
        head="ψ",
        stated_std=True,
        missing="the amplitude of the heading, yaw_amplitude_deg (or of the path, "
        "path_amplitude_m)",
        asked="amplitude of the heading [deg]",
        resolution=ANGLE,
        in_names=((r"(?:[Pp]si|ψ)#(?:deg|°)?", 1.0), (r"(?:a|A|[Aa]mp)#(?:deg|°)", 1.0)),
        header="(?:yaw|heading|psi)(?: angle)? ampl?(?:itude)?|psi ?[a0]|ψ ?[a0]",
        code="y",
        typical=0.2,
    ),
    RunSetting(
        name="rudder_amplitude",
        key="rudder_amplitude_deg",
        unit="deg",
        meaning="of a rudder that swings, about `rudder_deg`",
        bounds=SWING,
        of_swing=("delta",),
        place=6,
        told=Told(symbol="δ0", word="rudder swing", unit="°", form=".3g"),
        word="rudder amplitude",
        title="amplitude of the rudder",
        head="δ swing",
        stated_std=True,
        missing="the amplitude of the rudder, rudder_amplitude_deg",
        asked="amplitude of the rudder [deg]",
        resolution=ANGLE,
        header="(?:rudder|delta|δ)(?: angle)? ampl?(?:itude)?",
        sensors=(
            Sensor(
                column="delta swing",
                allowed=math.radians(1.5),
                share=0.05,
                remedy="The reduction takes the measured rudder. Set rudder_amplitude_deg from it, "
                "or look at its unit.",
            ),
        ),
        code="da",
        typical=0.2,
    ),
    RunSetting(
        name="path_amplitude_m",
        unit="m",
        meaning="of the path of a pure yaw test instead [m]: the heading is atan(aω/U)",
        bounds=POSITIVE,
        kept=False,
        states=("yaw_amplitude",),
        of_swing=("r",),
        without=("v",),
    ),
    RunSetting(
        name="strut_amplitude_m",
        unit="m",
        meaning="of each of two struts [m]",
        bounds=POSITIVE,
        kept=False,
        states=("amplitude", "yaw_amplitude"),
        of_swing=("v", "r"),
    ),
    RunSetting(
        name="strut_phase_deg",
        unit="deg",
        meaning="by which the forward strut leads",
        bounds=TURN,
        kept=False,
        of_swing=("r",),
    ),
    RunSetting(
        name="phase",
        key="phase_deg",
        unit="deg",
        meaning="of the displacement at t = 0",
        of_swing=ANY,
        word="phase",
        title="phase of the motion",
        zero_error="zero",
        stated_std=True,
    ),
    RunSetting(
        name="yaw_rate",
        unit="rad/s",
        meaning="of a circle [rad/s]",
        where_needed=True,
        place=8,
        told=Told(symbol="r", word="yaw rate", unit="°/s", form="+.3g", shown="turn_rate"),
        word="yaw rate",
        head="r",
        stated_std=True,
        missing="yaw_rate [rad/s] or radius [m]",
        asked="yaw rate [rad/s], or radius = ... [m]",
        typical=0.1,
    ),
    RunSetting(
        name="radius",
        unit="m",
        meaning="of a circle instead [m]",
        bounds=NOT_ZERO,
        states=("yaw_rate",),
        where_needed=True,
        word="radius",
        stated_std=True,
        in_names=((r"(?:R|[Rr]ad(?:ius)?)#(?:m)?", 1.0),),
    ),
    RunSetting(
        name="depth",
        unit="m",
        meaning="of the water, where it is not that of [water] [m]",
        surroundings=True,
        bounds=POSITIVE,
        place=11,
        told=Told(symbol="h", word="depth", unit=" m", form=".4g"),
        head="Depth",
        resolution=LENGTH,
    ),
    RunSetting(
        name="switch",
        key="switch_deg",
        unit="deg",
        meaning="heading at which a zigzag puts the rudder over",
        where_needed=True,
        bounds=TURN,
        place=9,
        told=Told(symbol="switch", word="switch", unit="°", form=".3g"),
        missing="the heading of the switch, switch_deg",
        asked="heading at which the rudder is put over [deg]",
        resolution=ANGLE,
        code="s",
        typical=0.17,
    ),
    RunSetting(
        name="wave_height",
        unit="m",
        meaning="significant height of the sea, of a free-running test [m]",
        surroundings=True,
        bounds=Bounds(least=0),
        place=12,
        told=Told(symbol="H", word="waves", unit=" m", form=".3g"),
        resolution=SEA,
    ),
    RunSetting(
        name="wave_period",
        unit="s",
        meaning="its peak period [s]",
        surroundings=True,
        bounds=POSITIVE,
        place=13,
        told=Told(symbol="Tp", word="waves of", unit=" s", form=".3g"),
        resolution=RATE,
    ),
    RunSetting(
        name="waves_from",
        key="waves_from_deg",
        unit="deg",
        meaning="where it comes from, clockwise from where the heading is zero",
        surroundings=True,
        bounds=Bounds(least=-360, most=360),
        place=14,
        told=Told(symbol="waves from", word="waves from", unit="°", form=".3g"),
        resolution=ANGLE,
    ),
    RunSetting(
        name="vdot_amplitude",
        unit="",
        meaning="v̇' of pure sway, instead of the amplitude",
        bounds=NOT_ZERO,
        kept=False,
        states=("amplitude",),
        of_swing=("u", "v"),
        header="vdot|v dot",
    ),
    RunSetting(
        name="v_amplitude",
        unit="",
        meaning="v' of pure sway, instead of it",
        bounds=NOT_ZERO,
        kept=False,
        states=("amplitude",),
        of_swing=("u", "v"),
        header="v",
    ),
    RunSetting(
        name="r_amplitude",
        unit="",
        meaning="r' of pure yaw, instead of the heading, or of a circle, instead of the rate",
        kept=False,
        states=("yaw_amplitude", "yaw_rate"),
        of_swing=("r",),
        where_needed=True,
        header="r",
    ),
    RunSetting(
        name="rdot_amplitude",
        unit="",
        meaning="ṙ' of pure yaw, instead of it",
        bounds=NOT_ZERO,
        kept=False,
        states=("yaw_amplitude",),
        of_swing=("r",),
        header="rdot|r dot",
    ),
)
_PLACED: Final = frozenset(item.name for item in _OURS if item.kept)
"""Settings that `Settings` has a place of its own for."""
_TABLE_CHANNELS: Final = (*FORCE_CHANNELS, "n", "sinkage", "trim")
_BESIDE: Final = {"turn_rate": RATE, "strut_spacing": LENGTH, "strut_centre": LENGTH}
"""The same of what no key of a file states."""


class RunSettings(Registry[RunSetting]):
    """The settings of a run by name, and how campaign files state them."""

    @property
    def brought(self) -> tuple[RunSetting, ...]:
        """Settings that kinds of test bring along, which `Settings` keeps in `further`."""
        return self.derived(_brought)

    @property
    def told(self) -> tuple[RunSetting, ...]:
        """Settings that are told, in their order."""
        return self.derived(_told)

    @property
    def by_key(self) -> Mapping[str, RunSetting]:
        """All settings by their keys in files."""
        return self.derived(_by_key)

    @property
    def units(self) -> Mapping[str, str]:
        """Unit of each as the campaign file states it, by key."""
        return self.derived(_units)

    @property
    def resolution(self) -> Mapping[str, Resolution]:
        """How far two values of a setting may differ and still be the same one.

        Absolute (SI, radians) and relative. The phase is not among them: it says when a record
        begins, not what was tested.
        """
        return self.derived(_resolution)

    def key_of(self, name: str) -> str:
        """Key of a campaign file that states a setting; a name that is none of one as it is.

        Examples
        --------
        >>> RUN_SETTINGS.key_of("drift"), RUN_SETTINGS.key_of("period")
        ('drift_deg', 'period')
        """
        known = self.get(name)
        return name if known is None else known.in_file

    def ways_to_state(self, name: str) -> frozenset[str]:
        """Keys of a campaign file any of which states a setting.

        Examples
        --------
        >>> [sorted(RUN_SETTINGS.ways_to_state(name)) for name in ("period", "yaw_rate")]
        [['frequency_hz', 'period'], ['r_amplitude', 'radius', 'yaw_rate']]
        """
        return frozenset(
            item.in_file for item in self.values() if name in (item.name, *item.states)
        )


RUN_SETTINGS: Final = RunSettings(
    RunSetting,
    lambda: _OURS,
    what="setting",
    listed="pmmkit.campaigns.test_kinds:SETTINGS",
    group=GROUP,
    contract="pmmkit.testing.test_kinds:check_run_setting",
)
"""All settings of a run by name, in the order of their keys: those of `Settings`, then those that
kinds of test bring along."""


def _brought(settings: Iterable[RunSetting]) -> tuple[RunSetting, ...]:
    return tuple(item for item in settings if item.kept and item.name not in _PLACED)


def _told(settings: Iterable[RunSetting]) -> tuple[RunSetting, ...]:
    return tuple(sorted((item for item in settings if item.told), key=lambda item: item.place))


def _by_key(settings: Iterable[RunSetting]) -> Mapping[str, RunSetting]:
    return MappingProxyType({item.in_file: item for item in settings})


def _units(settings: Iterable[RunSetting]) -> Mapping[str, str]:
    return MappingProxyType({item.in_file: item.unit for item in settings})


def _resolution(settings: Iterable[RunSetting]) -> Mapping[str, Resolution]:
    found = {item.name: item.resolution for item in settings if item.resolution is not None}
    return MappingProxyType(found | _BESIDE)


def unit_of(name: str, *, table: bool, unasked: bool = False) -> str | None:
    """SI unit, or the one in the name, of a column of that name; None if the name is not known.

    Parameters
    ----------
    name : str
        Name of a channel, and for tables of a setting, of a mean or of a harmonic.
    table : bool
        Whether the file is a table whose rows are runs.
    unasked : bool
        Whether only names count that are taken without being mapped. In a table a column ``r`` or
        ``v`` is too often a non-dimensional amplitude: velocities are taken there only where the
        campaign file maps them.
    """
    if table:
        if name in RUN_SETTINGS.units:
            return RUN_SETTINGS.units[name]
        part = harmonic_part(name)
        if part is not None:
            return CHANNEL_UNITS[part[0]]
        if unasked and name not in _TABLE_CHANNELS:
            return None
    if name in CHANNEL_UNITS:
        return CHANNEL_UNITS[name]
    found = unit_in_name(name)
    return None if found is None else found[1]
