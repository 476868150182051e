"""What the runs of a campaign cannot tell of their own errors, and what would."""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.conventions import CHANNELS
from pmmkit.intake.checks.finding import Summary
from pmmkit.intake.checks.inertia import unasked_inertia
from pmmkit.presentation import WIDE, listed

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign, Run
    from pmmkit.numerics import Array

FOLLOWS: Final = 0.5
"""Share of the variance of the day that a factor explains, corrected for chance, from which a drift
is no longer told from a change with it: the drift's variance is doubled. Two blocks of runs have
0.75, three 0.88; of random orders of 16 runs one in a hundred comes so far."""
FEWEST: Final = 16
"""Runs below which a random order may look like one by speed (of 8 runs one in ten does)."""
SLIP: Final = 0.01
"""Slip of the moments' point whose effect is told, over L: a few centimetres of a model, as far as
a balance, its adapter and midship are often apart from their drawing."""
MOVED: Final = ("v", "r", "vdot", "rdot")
"""Motions whose derivatives of N are looked at: those that stability and turning hang on."""


@dataclass(frozen=True, kw_only=True)
class Untold:
    """Something that runs cannot tell of their own errors.

    Parameters
    ----------
    name : str
        What it is, for programs: ``scale``, ``moments' point``, ``day``, ``side``, ``amplitude``,
        ``inertia inside``, ``inertia``, ``reference values``, ``one speed``, ``one frequency``.
    text : str
        That in a sentence or two.
    check : str
        A sentence on what would tell it.
    condition : str
        What must be right for the derivatives to hold, as the verdict's line has it; empty where
        no derivative hangs on it.

    Examples
    --------
    >>> print(Untold(name="one speed", text="All runs are at one speed.", check="Add another."))
    All runs are at one speed. Add another.
    """

    name: str
    text: str
    check: str
    condition: str = ""

    def __str__(self) -> str:
        return f"{self.text} {self.check}"

    def to_dict(self) -> dict[str, str]:
        """As plain data."""
        return asdict(self)

    @classmethod
    def of(
        cls,
        campaign: Campaign,
        summaries: Sequence[Summary] | None = None,
        *,
        values: Mapping[str, float] | None = None,
        recorded: bool = False,
    ) -> tuple[Untold, ...]:
        """What the runs of a campaign leave open, what most hangs on first.

        It follows from what is stated: settings, order, reference values. So it can be asked
        of runs that are planned.

        Parameters
        ----------
        campaign : Campaign
            Captive tests, made or planned; of others nothing is said.
        summaries : sequence of Summary, optional
            Of its runs, where they were read: which channels they have, whether the motion was
            recorded and zeros were taken off, and whether the inertia is inside.
        values : mapping of str to float, optional
            Derivatives of Y and N as far as they are known, non-dimensional: they tell how much a
            slip of the moments' point moves.
        recorded : bool
            Whether the motion is recorded, where there are no summaries.

        Returns
        -------
        tuple of Untold

        Examples
        --------
        >>> from pmmkit.campaigns import open_campaign
        >>> found = Untold.of(open_campaign("datasets/s175"))
        >>> found[0].condition
        "the gauges' scale (X, Y, N)"
        """
        if campaign.kind != "captive" or not campaign.runs:
            return ()
        read = summaries is not None
        seen = _Seen(
            campaign=campaign,
            summaries=tuple(summaries or [Summary(run=run) for run in campaign.runs]),
            read=read,
            recorded=recorded,
        )
        return tuple(
            item
            for item in (
                _scale(seen),
                _point(seen, values or {}),
                _day(seen),
                _side(seen),
                _amplitude(seen),
                _inside(seen),
                _inertia(seen),
                _reference_values(seen),
                _one_speed(seen),
                _one_frequency(seen),
            )
            if item is not None
        )


@dataclass(frozen=True, kw_only=True)
class _Seen:
    """Runs and what is known of them; `read`: whether that is more than their settings."""

    campaign: Campaign
    summaries: tuple[Summary, ...]
    read: bool
    recorded: bool

    @property
    def runs(self) -> tuple[Run, ...]:
        """The runs."""
        return tuple(item.run for item in self.summaries)

    @property
    def swung(self) -> tuple[Summary, ...]:
        """Those that oscillate."""
        return tuple(item for item in self.summaries if item.run.dynamic)

    @property
    def channels(self) -> tuple[str, ...]:
        """Forces that are measured; X, Y and N where nothing was read."""
        if not self.read:
            return CHANNELS[:3]
        return tuple(name for name in CHANNELS if any(name in x.means for x in self.summaries))

    @property
    def computed(self) -> bool:
        """Whether a solver stands for the tank."""
        return self.campaign.computed

    def always(self, fact: str) -> bool:
        """Whether a fact holds of every run that was read."""
        return self.read and all(item.facts.get(fact) for item in self.summaries)


def _scale(seen: _Seen) -> Untold | None:
    checked = {check.channel for check in seen.campaign.gauge_checks if check.agrees}
    names = [name for name in seen.channels if name not in checked]
    if not names:
        return None
    if seen.computed:
        return Untold(
            name="scale",
            text=f"Not checked by these runs: the scale of {listed(names)}. A factor or a unit "
            "that is off in all runs alike goes into every derivative.",
            check="A case whose forces are published checks it.",
            condition=f"the scale of the forces ({', '.join(names)})",
        )
    gauges = "the gauges" if len(names) > 1 else "the gauge"
    return Untold(
        name="scale",
        text=f"Not checked by these runs: the scale of {gauges} of {listed(names)}. A gain or a "
        "unit that is off in all runs alike goes into every derivative one to one.",
        check='Known weights on the balance (test = "check_load") check it.',
        condition=f"the gauges' scale ({', '.join(names)})",
    )


def _point(seen: _Seen, values: Mapping[str, float]) -> Untold | None:
    if not {"Y", "N"} <= set(seen.channels):
        return None
    campaign = seen.campaign
    x = campaign.moment_reference_x
    if any(check.at(x) for check in campaign.gauge_checks):
        return None
    stated = [item for item in campaign.uncertainty if item.name == "moment_reference_x"]
    std = math.hypot(*(item.moved(x) - x for item in stated))
    where = f"x = {x:.4g} ± {WIDE * std:.2g} m" if std else f"x = {x:.4g} m"
    worst = _most_moved(values)
    slip = f"{SLIP:g} L ({SLIP * campaign.ship.L:.2g} m)"
    told = (
        f"A slip of {slip} moves {worst[0]} by {100 * worst[1]:.2g} %."
        if worst is not None
        else f"A slip of {slip} moves each derivative of N by {SLIP:g} of that of Y, Nvdot most."
    )
    return Untold(
        name="moments' point",
        text=f"Not checked by these runs: the point about which N is stated ({where}). {told}",
        check='Side loads at two stations along the model (test = "check_load") check it.',
        condition=f"the moments' point ({where})",
    )


def _most_moved(values: Mapping[str, float]) -> tuple[str, float] | None:
    """The derivative of N that a slip of the moments' point moves most, and by what share.

    With N about another point by dx, N grows by dx Y and so each of its derivatives by dx/L times
    that of Y, in every system.
    """
    shares = {
        name: abs(SLIP * values[other] / values[name])
        for name, other in ((f"N{motion}", f"Y{motion}") for motion in MOVED)
        if values.get(name)
        and math.isfinite(values[name])
        and math.isfinite(values.get(other, math.nan))
    }
    worst = max(shares, key=lambda name: shares[name], default=None)
    return None if worst is None else (worst, shares[worst])


def _day(seen: _Seen) -> Untold | None:
    """An order in which a drift of the gauges looks like something else; none where each record
    shows its zero at rest."""
    if seen.computed or seen.always("tared") or seen.always("rest_s"):
        return None
    runs = seen.runs
    day = np.array(seen.campaign.with_(runs=runs).places_in_day)
    sides = [(place, side) for place, run in enumerate(runs) if (side := _side_of(run))]
    factors: dict[str, tuple[Array, Sequence[Hashable]]] = {
        "the speed": (day, [_speed_of(run) for run in runs]),
        "the kind of test": (day, [run.test for run in runs]),
        "the side": (day[[place for place, _ in sides]], [side for _, side in sides]),
    }
    shares = {name: share_of_day(*own) for name, own in factors.items()}
    found = {name: x for name, x in shares.items() if x > FOLLOWS}
    if not found:
        return None
    like = {
        "the speed": "a change with the speed",
        "the kind of test": "a difference between kinds of test",
        "the side": "an asymmetry",
    }
    timed = all(run.start is not None for run in runs)
    order = "Through the day" if timed else "In the order in which they stand"
    told = [f"{name} (it explains {100 * x:.0f} % of their order)" for name, x in found.items()]
    other = "" if timed else " If they were made in another order, state started of each run."
    return Untold(
        name="day",
        text=f"{order} the runs go by {listed(told)}: a zero or a gain of a gauge that drifts is "
        f"not told from {' or '.join(like[name] for name in found)}.",
        check="A random order, the first runs again at the end, or a zero before each run (tare) "
        f"tell it.{other}",
        condition="the gauges' zeros and gains through the day",
    )


def share_of_day(day: Array, levels: Sequence[Hashable]) -> float:
    """Share of the variance of the place in the day that the level of a factor explains.

    Corrected for what chance explains (Ezekiel's adjusted R²): 0 of a random order, 1 where the
    level follows from the place. Nothing, 0, of too few runs or a single level.

    Examples
    --------
    >>> day = np.linspace(0.0, 1.0, 24)
    >>> round(share_of_day(day, [1.0] * 12 + [2.0] * 12), 2), share_of_day(day, [1.0, 2.0] * 12)
    (0.74, 0.0)
    """
    count, groups = len(day), list(dict.fromkeys(levels))
    if count < FEWEST or not 1 < len(groups) < count - 1:
        return 0.0
    own = np.array([groups.index(level) for level in levels])
    means = np.array([day[own == place].mean() for place in range(len(groups))])
    whole = float(np.sum((day - day.mean()) ** 2))
    left = float(np.sum((day - means[own]) ** 2)) / whole if whole > 0 else 1.0
    return max(0.0, 1.0 - left * (count - 1) / (count - len(groups)))


def _speed_of(run: Run) -> float:
    """A speed as programmes set it, to a per cent."""
    return round(math.log(run.settings.speed), 2)


def _side_of(run: Run) -> int:
    """To which side a run is held: 1, -1, or 0 for one straight ahead or swung about it."""
    settings = run.settings
    held = settings.drift or settings.turn_rate or settings.rudder
    return 0 if abs(held) < 1e-6 else int(math.copysign(1, held))


def _side(seen: _Seen) -> Untold | None:
    runs = seen.runs
    sides = {side for run in runs if (side := _side_of(run))}
    about_zero = any(run.dynamic and not _side_of(run) for run in runs)
    if len(sides) != 1 or about_zero:
        return None
    return Untold(
        name="side",
        text="All runs are held to one side: an asymmetry of the hull, an angle that is off in all "
        "runs alike and the even part of a force are not told apart.",
        check="Two of the largest angles to the other side tell them.",
        condition="the alignment",
    )


def _amplitude(seen: _Seen) -> Untold | None:
    swung = seen.swung
    recorded = seen.recorded or any("v_mean" in x.facts or "r_mean" in x.facts for x in swung)
    statics = any(item.run.test == "static_drift" for item in seen.summaries)
    if not swung or recorded or statics:
        return None
    return Untold(
        name="amplitude",
        text="Not checked by these runs: the amplitude of the oscillations, as nothing but the "
        "settings tells the motion.",
        check="Recording it, or static drift beside sway, checks it.",
        condition="the amplitudes as set",
    )


def _inside(seen: _Seen) -> Untold | None:
    unasked = unasked_inertia(seen.campaign, seen.summaries) if seen.read else ()
    if not unasked:
        return None
    return Untold(
        name="inertia inside",
        text=f"Not told by these runs: whether the model's inertia is inside {listed(unasked)}, as "
        "the campaign file says or not: nothing moves alone there, or the added mass is not known "
        "well enough.",
        check="A run of the dry model on the balance tells it.",
        condition=f"what is said of the inertia in {listed(unasked)}",
    )


def _inertia(seen: _Seen) -> Untold | None:
    yaws = [item for item in seen.summaries if item.run.kind_of_test.yaws]
    weighed = any(item.run.forces == "balance" for item in seen.summaries)
    if not yaws or (seen.computed and not weighed):
        return None
    what = "balance_Izz (Izz)" if weighed else "the moment of inertia Izz that was taken off"
    return Untold(
        name="inertia",
        text=f"Not checked by these runs: {what}, which goes into Nrdot one to one, and the centre "
        "of gravity.",
        check="Swinging the dry model on the balance checks them.",
        condition="the inertia (Izz, xG)",
    )


def _reference_values(seen: _Seen) -> Untold | None:
    if not seen.channels:
        return None
    what = "the length L and the density" if seen.computed else "the length L, density and speed"
    names = "L, density" if seen.computed else "L, density, speed"
    return Untold(
        name="reference values",
        text=f"Not checked by these runs: {what} that make the derivatives non-dimensional.",
        check="The drawing of the model checks them."
        if seen.computed
        else "A tape, a thermometer and an independent speed log check them.",
        condition=f"the reference values ({names})",
    )


def _one_speed(seen: _Seen) -> Untold | None:
    if len({_speed_of(run) for run in seen.runs}) > 1:
        return None
    zero = "" if seen.computed or seen.always("tared") else _ZERO
    return Untold(
        name="one speed",
        text=f"All runs are at one speed: {zero}what changes with the Froude number is not seen.",
        check="Some of the runs at a second speed tell it.",
    )


_ZERO: Final = (
    "the zero of a gauge and an asymmetry of the hull are one and the same (Y0, N0), and "
)


def _one_frequency(seen: _Seen) -> Untold | None:
    if len({item.run.settings.omega for item in seen.swung}) != 1:
        return None
    return Untold(
        name="one frequency",
        text="Not told apart by these runs: a lag in seconds, a filter and a phase, as all "
        "oscillate at one frequency.",
        check="A run at another frequency tells them apart.",
    )
