"""The conditions under which the standard is to be judged, and which of them a test meets."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final, Self

from pmmkit.conventions import Criterion
from pmmkit.simulation import wave_height_of

if TYPE_CHECKING:
    from pmmkit.models import Model

SHORTEST: Final = 100.0
"""Length from which on the standard applies [m]: MSC.137(76)."""
DEEP: Final = 4.0
"""Depth over mean draught of deep water: MSC/Circ.1053, 2.2.1.2.1."""
WINDIEST: Final = 5
"""Beaufort number not to be exceeded: the same."""
ROUGHEST: Final = 4
"""Sea state not to be exceeded: the same."""
LOADED: Final = 0.05
"""Share by which the draught may differ from that of full load: MSC/Circ.1053, 2.2.1.2.2."""
FAST: Final = 0.9
"""Least share of the speed at 85 % of the engine's output: MSC.137(76)."""
WINDS: Final = (0.2, 1.5, 3.3, 5.4, 7.9, 10.7, 13.8, 17.1, 20.7, 24.4, 28.4, 32.6)
"""Upper ends of Beaufort 0 to 11 [m/s], of the mean over ten minutes at a height of 10 m."""
SEAS: Final = (0.0, 0.1, 0.5, 1.25, 2.5, 4.0, 6.0, 9.0, 14.0)
"""Upper ends of sea states 0 to 8 by significant height [m]: WMO code 3700."""
SIMULATED: Final = "none, as simulated"
"""What is shown of wind, sea and current of a simulation."""


def beaufort(speed: float) -> int:
    """Beaufort number of a wind [m/s].

    Examples
    --------
    >>> beaufort(0.0), beaufort(10.7), beaufort(10.8), beaufort(40.0)
    (0, 5, 6, 12)
    """
    return sum(speed > end for end in WINDS)


def sea_state(height: float) -> int:
    """State of a sea by WMO code 3700, of a significant height [m].

    Examples
    --------
    >>> sea_state(0.0), sea_state(2.5), sea_state(4.5), sea_state(20.0)
    (0, 4, 6, 9)
    """
    return sum(height > end for end in SEAS)


@dataclass(frozen=True, kw_only=True)
class Condition:
    """A condition of the standard beside what it was in a test.

    Parameters
    ----------
    name, title : str
        As a key, and in words.
    standard : str
        What the standard asks for.
    value : float or None
        What it was; None where nobody said, or there is no number.
    shown : str
        The same in words; empty where nobody said.
    met : bool or None
        None where that is not known.
    words : str
        A sentence for one that is not met, or not known.
    excess : float
        Grows with the distance from meeting it: which of several tests was the worst.
    """

    name: str
    title: str
    standard: str
    value: float | None = None
    shown: str = ""
    met: bool | None = None
    words: str = ""
    excess: float = 0.0

    @classmethod
    def of_length(cls, L: float) -> Self:
        """The length of the ship [m]."""
        return cls(
            name="length",
            title="length",
            standard=f"{SHORTEST:g} m or more",
            value=L,
            shown=f"{L:.4g} m",
            met=L >= SHORTEST,
            words=f"The standard is for ships of {SHORTEST:g} m and more; this one has "
            f"L = {L:.4g} m.",
        )

    @classmethod
    def of_depth(cls, depth: float | None, draught: float, *, deep: bool = False) -> Self:
        """The depth of the water over the mean draught.

        Parameters
        ----------
        depth : float or None
            [m]
        draught : float
            Mean draught [m].
        deep : bool
            Whether no depth means water without a bottom: that of a simulation.
        """
        standard = f"more than {DEEP:g} draughts"
        asked = cls(name="depth", title="depth", standard=standard)
        if depth is None:
            return replace(asked, shown="no bottom" if deep else "", met=deep or None)
        ratio = depth / draught
        return replace(
            asked,
            value=ratio,
            shown=f"{depth:.4g} m, {ratio:.1f} draughts",
            met=ratio > DEEP,
            excess=-ratio,
            words=f"The standard asks for deep water, {standard}; this is {ratio:.1f}.",
        )

    @classmethod
    def of_wind(cls, speed: float | None, number: int | None = None) -> Self:
        """The wind: its mean true speed [m/s] as measured, else its Beaufort number as stated."""
        standard = f"at most Beaufort {WINDIEST}"
        own = number if speed is None else beaufort(speed)
        asked = cls(name="wind", title="wind", standard=standard)
        if own is None:
            return asked
        shown = f"Beaufort {own}" + ("" if speed is None else f", {speed:.1f} m/s")
        said = f"is {speed:.1f} m/s" if speed is not None else f"is Beaufort {own}"
        return replace(
            asked,
            value=own,
            shown=shown,
            met=own <= WINDIEST,
            excess=own if speed is None else speed,
            words=f"The standard asks for calm weather, {standard}; the wind {said}.",
        )

    @classmethod
    def of_sea(cls, state: int | None) -> Self:
        """The sea state, as stated."""
        asked = cls(name="sea_state", title="sea state", standard=f"at most {ROUGHEST}")
        if state is None:
            return asked
        return replace(
            asked,
            value=state,
            shown=f"{state}",
            met=state <= ROUGHEST,
            words=f"The standard asks for a sea state of at most {ROUGHEST}; this is {state}.",
        )

    @classmethod
    def of_current(cls, known: bool, shown: str) -> Self:
        """The current: uniform at most, and removed."""
        return cls(
            name="current",
            title="current",
            standard="uniform, corrected for",
            shown=shown if known else "not known: lengths over ground",
            met=known,
            words="The current is not known: the lengths are over ground.",
        )

    @classmethod
    def of_draught(cls, draught: float, full: float | None) -> Self:
        """The mean draught beside that of full load [m]."""
        standard = f"full load within {100 * LOADED:g} %"
        asked = cls(name="draught", title="draught", standard=standard)
        if full is None:
            return replace(asked, shown=f"{draught:.4g} m, that of full load not supplied")
        share = draught / full - 1.0
        return replace(
            asked,
            value=share,
            shown=f"{draught:.4g} m, {100 * share:+.1f} % of full load {full:.4g} m",
            excess=abs(share),
            met=abs(share) <= LOADED * (1.0 + 1e-12),
            words=f"The standard asks for the draught of full load, {full:.4g} m, within "
            f"{100 * LOADED:g} %; this is {draught:.4g} m.",
        )

    @classmethod
    def of_approach(cls, speed: float, full: float | None) -> Self:
        """The approach speed beside that at 85 % of the engine's output [m/s]."""
        standard = f"at least {100 * FAST:g} % of that at 85 % of the engine's output"
        asked = cls(name="approach", title="approach speed", standard=standard)
        if full is None:
            return replace(
                asked,
                excess=-speed,
                shown=f"{speed:.4g} m/s, that at 85 % not supplied",
                words=f"The approach speed, {speed:.4g} m/s, must be {standard}, which is not "
                "stated.",
            )
        share = speed / full
        return replace(
            asked,
            value=share,
            shown=f"{speed:.4g} m/s, {100 * share:.1f} % of {full:.4g} m/s",
            excess=-share,
            met=share >= FAST * (1.0 - 1e-12),
            words=f"The approach speed must be {standard}, {full:.4g} m/s; this is "
            f"{speed:.4g} m/s, "
            f"{100 * share:.0f} %.",
        )

    @classmethod
    def of_rudder(cls, rudder_deg: float) -> Self:
        """The rudder of a turning circle [deg]; whether more is permitted nobody shows."""
        size = abs(rudder_deg)
        return cls(
            name="rudder",
            title="rudder of the turning circle",
            standard=f"{Criterion.HARD_OVER:g}° or the largest permissible",
            value=size,
            shown=f"{size:.1f}°",
            excess=-size,
            met=True if size > Criterion.HARD_OVER - 0.5 else None,
            words=f"The standard asks for {Criterion.HARD_OVER:g}° of rudder or the largest "
            f"permissible; this is {size:.1f}°.",
        )


def simulated_conditions(
    model: Model,
    speed: float,
    *,
    depth: float | None = None,
    wind_speed: float = 0.0,
    current_speed: float = 0.0,
    wave_height: float | None = None,
    revolutions: float | str | None = None,
    full_speed: float | None = None,
    full_draught: float | None = None,
) -> tuple[Condition, ...]:
    """What the standard asks of a ship, and what a simulation of her was.

    Parameters
    ----------
    model : Model
        At the scale and in the loading that sail; she may feel waves of her own.
    speed : float
        Of the approach [m/s].
    depth : float, optional
        Of the water [m]; without it there is no bottom.
    wind_speed, current_speed : float
        That she was sailed in [m/s].
    wave_height : float, optional
        That she was sailed in, in place of her own [m].
    revolutions : float or "speed", optional
        As of `simulate`: whether the lever was held in the waves, or the speed.
    full_speed, full_draught : float, optional
        Speed at 85 % of the engine's output [m/s], mean draught of full load [m].
    """
    ship, height = model.ship, wave_height_of(model, wave_height)
    sea = Condition.of_sea(sea_state(height))
    held = ", speed held" if revolutions == "speed" else ", lever held"
    told = f"{sea.shown}, Hs {height:.3g} m{held}" if height > 0.0 else SIMULATED
    wind, current = Condition.of_wind(wind_speed), Condition.of_current(True, SIMULATED)
    flow = f"{current_speed:.3g} m/s, not corrected for"
    return (
        Condition.of_length(ship.L),
        Condition.of_depth(depth, ship.d, deep=True),
        wind if wind_speed else replace(wind, shown=SIMULATED),
        replace(sea, shown=told),
        replace(current, met=False, shown=flow, words=_OVER_GROUND) if current_speed else current,
        Condition.of_draught(ship.d, full_draught),
        Condition.of_approach(speed, full_speed),
    )


_OVER_GROUND: Final = "The current is not corrected for: the lengths are over ground."
