"""Whether a table can be used: one line, with the doubts that belong to it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.effects import AddedMass
from pmmkit.inference import RunEffects
from pmmkit.intake import CheckFinding
from pmmkit.models import DerivativeTable, TableVerdict
from pmmkit.numerics import Array
from pmmkit.presentation import at_froude, listed
from pmmkit.reduction.estimate import ChannelFit
from pmmkit.reduction.influence import Influence, Influences
from pmmkit.reduction.observations.equations import Rows
from pmmkit.reduction.propulsion import TOGETHER, thrust_inside
from pmmkit.reduction.solve import SPEED_GAP, Solution

BUDGET: Final = 0.01
"""Chance, in a campaign whose runs are sound, of each kind of doubt that noise can raise: families
that disagree, a run at odds, a warning of the checks, a name, and what is unexplained. All together
stay below 5 % (scripts.studies.false_alarms)."""
LOST: Final = 0.5
"""Share of the rms force that a fit leaves from which it fits nothing. A structure that lacks a
main effect leaves up to a quarter (S175, `cubic`, all speeds: 0.27 of N)."""
BEYOND: Final = 3.0
"""Times the noise that it must leave as well: a small force, such as X at self-propulsion, may be
all scatter and fitted well."""
FAR: Final = 30.0
"""Standard deviations from which a run that is at odds is no measurement of the same thing."""
AWAY: Final = 0.5
"""Share of the rms force that a run must miss, too, as one of another sign, unit or factor does. A
structure that lacks a term is no fault of the tests: without products of sway and yaw the S175's
largest yaw with drift is 44 standard deviations and a third of the force away, and of forces
without noise, as solvers give them, a per mille is hundreds of standard deviations."""
SHARED: Final = 4
"""Derivatives of two families below which chance may part most of them."""
APART: Final = 0.5
"""Share of the larger value by which they must differ as well. No structure is exact: in HMRI's
tests of the KVLCC2 the intervals of static drift and pure sway part in four derivatives of five,
two of which differ by so much."""
WORST: Final[Mapping[str, float]] = {"offset": 0.5, "gain": 0.25, "drift": 2.0, "harmonics": 0.5}
"""Scatter between runs that no laboratory has: offset and each harmonic over the rms force, gain,
drift setting [deg]. Surge near self-propulsion is a small force: that of Flanders Hydraulics' KCS
repeats to a fifth of its rms. Repeated tests agree to some per cent and some hundredths of a degree
(ITTC 7.5-02-06-04); ten times that is another quantity, unit or sign in some of the runs."""
NEGATIVE: Final = ("Xudot", "Yvdot", "Nrdot", "Kpdot", "Yv", "Nr", "Xuu")
"""Derivatives that are negative for every hull."""
MASS: Final = ("Yvdot", "Nrdot")
"""Without these nothing is known of the mass matrix."""
TOLD: Final = 4
"""Names that a sentence lists."""


def verdict(
    table: DerivativeTable,
    families: Mapping[str, DerivativeTable],
    solution: Solution,
    influences: Influences,
    findings: Sequence[CheckFinding],
    rows: Sequence[Rows],
    *,
    conditions: Sequence[str] = (),
    weighed: bool = False,
) -> TableVerdict:
    """Judge a reduction by everything that it found, on conditions that it cannot check."""
    inside = thrust_inside(solution, rows)
    pushes = solution.Fn[list(inside)]
    far = [] if weighed else [one for one in influences.odd if _far(one, solution, rows)]
    pushed = any(item.result.run.settings.propeller_rps for item in rows)
    wrong = [name for name in _positive(table) if name != "Xuu" or not pushed]
    return TableVerdict(
        faults=(
            *(str(item) for item in findings if item.severity == "error"),
            *_nothing(table),
            *_signs(wrong),
            *_beyond(far),
            *_lost(solution),
            *_contradicting(families, pushes),
            *_scattered(solution),
            *_massless(table),
        ),
        doubts=(
            *_misfit(solution),
            *_pushed(solution, inside),
            *_disagreeing(table, families, pushes),
            *_odd([one for one in influences.odd if one not in far]),
            *_signs([name for name in _positive(table) if name not in wrong]),
            *(
                f"The checks warn: {item.message}"
                for item in findings
                if item.severity == "warning" and item.check != "odd_run"
            ),
        ),
        conditions=tuple(conditions),
    )


def _nothing(table: DerivativeTable) -> Iterator[str]:
    if not np.isfinite(table.value).any():
        yield "these runs determine none of the derivatives."


def _lost(solution: Solution) -> Iterator[str]:
    for group, item in solution.fits:
        if _is_lost(item):
            yield (
                f"{item.channel}{at_froude(solution.Fn[group])}: the fit leaves "
                f"{100 * item.left:.0f} % of the force, {math.sqrt(item.scale):.0f} times the "
                f"noise. Its intervals are none."
            )


def _is_lost(item: ChannelFit) -> bool:
    """Whether a fit fits nothing: much is left, and far more than repeats or noise make."""
    return item.excessive and item.left > LOST and item.scale > BEYOND**2


def _misfit(solution: Solution) -> Iterator[str]:
    for group, item in solution.fits:
        if item.excessive and not _is_lost(item):
            yield (
                f"{item.channel}{at_froude(solution.Fn[group])}: the misfit is "
                f"{math.sqrt(item.scale):.1f} times the noise ({100 * item.left:.1f} % of the "
                f"force), and scatter between runs does not explain it. The structure lacks "
                f"something: diagnose names it. Intervals are wider, but do not hold its bias."
            )


def _pushed(solution: Solution, inside: Sequence[int]) -> Iterator[str]:
    """Speeds at which Xuu holds the thrust of the propeller."""
    if inside:
        places = ", ".join(f"{solution.Fn[group]:.3f}" for group in inside)
        at = "" if np.isnan(solution.Fn[inside[0]]) else f" at Fn {places}"
        yield (
            f"Xuu{at} is thrust less resistance: the propeller turned, and its thrust was not "
            f"measured, or went with the speed. Tows without propeller, or at several "
            f"revolutions, part the two. A model takes an estimate of the resistance."
        )


def _disagreeing(
    table: DerivativeTable, families: Mapping[str, DerivativeTable], pushes: Array
) -> Iterator[str]:
    """Families of tests whose intervals do not touch those of all tests together, so wide
    that noise parts any of them in `BUDGET` of campaigns.
    """
    asked = sum(name in table for own in families.values() for name in own.names for _ in own.Fn)
    confidence = 1.0 - BUDGET / max(asked, 1)
    low, high = table.interval(confidence)
    for title, own in families.items():
        below, above = own.interval(confidence)
        told = []
        for row, Fn in enumerate(own.Fn):
            at = 0 if table.pooled else int(np.argmin(np.abs(table.Fn - Fn)))
            for name in (x for x in own.names if x in table and not _inside(x, Fn, pushes)):
                here, there = own.index(name), table.index(name)
                if below[row, here] > high[at, there] or above[row, here] < low[at, there]:
                    told.append(name)
        if told:
            yield (
                f"{title.capitalize()} alone gives other values of "
                f"{_list(list(dict.fromkeys(told)))} than all tests together: the intervals do "
                f"not touch."
            )


def _odd(found: Sequence[Influence]) -> Iterator[str]:
    for run in dict.fromkeys(one.run for one in found):
        channels = [one.channel for one in found if one.run == run]
        yield f"Run {run} is at odds with the others in {_list(list(dict.fromkeys(channels)))}."


def _positive(table: DerivativeTable) -> list[str]:
    """Added masses and damping of a sign that no hull has, beyond their intervals."""
    low, _ = table.interval()
    asked = NEGATIVE if table.convention.surge != "delta-u" else NEGATIVE[:-1]
    return [name for name in table.names if name in asked and np.any(low[:, table.index(name)] > 0)]


def _signs(names: Sequence[str]) -> Iterator[str]:
    for name in names:
        pushed = ", or thrust that is inside" if name == "Xuu" else ""
        yield f"{name} is positive, which no hull has: check signs, units and inertia{pushed}."


def _far(one: Influence, solution: Solution, rows: Sequence[Rows]) -> bool:
    """Whether a run at odds departs beyond anything, in standard deviations and in newtons."""
    if not one.departure > FAR:
        return False
    for group, item in solution.fits:
        if item.channel == one.channel:
            size = np.sqrt(np.mean(np.concatenate([block.rows for block in item.blocks]) ** 2))
            for block, rest in zip(item.blocks, item.residual, strict=True):
                run = rows[solution.groups[group][block.run]].result.run.id
                if run == one.run and np.sqrt(np.mean(rest**2)) > AWAY * size:
                    return True
    return False


def _beyond(far: Sequence[Influence]) -> Iterator[str]:
    """Runs that depart beyond anything, a sentence for all of them."""
    if far:
        worst = max(far, key=lambda one: one.departure)
        runs = list(dict.fromkeys(one.run for one in sorted(far, key=lambda x: -x.departure)))
        yield (
            f"{'Run' if len(runs) == 1 else 'Runs'} {_list(runs)} cannot be of the same ship and "
            f"signs as the others: {worst.run} departs from them by {worst.departure:.0f} standard "
            f"deviations in {worst.channel}. Mend or exclude."
        )


def _inside(name: str, Fn: float, pushes: Array) -> bool:
    """Whether a derivative cannot be told at a Froude number where Xuu holds the thrust."""
    same = np.isclose(pushes, Fn, rtol=SPEED_GAP, atol=0, equal_nan=True)
    return name in TOGETHER and bool(same.any())


def _contradicting(families: Mapping[str, DerivativeTable], pushes: Array) -> Iterator[str]:
    """Two families of which most derivatives that both determine have nothing in common."""
    for (title, one), (other, two) in combinations(families.items(), 2):
        names = [x for x in one.names if x in two and not x.endswith("0")]
        each = [_apart(one, two, name, pushes) for name in names]
        known = sum(len(found) for found in each)
        parted = sum(int(found.sum()) for found in each)
        if known >= SHARED and 2 * parted > known:
            told = [name for name, found in zip(names, each, strict=True) if found.any()]
            yield (
                f"{title.capitalize()} and {other} contradict each other: of {known} values that "
                f"both determine {parted} have nothing in common ({_list(told)}). Check signs, "
                f"phases, units and inertia of one of them."
            )


def _apart(
    one: DerivativeTable, two: DerivativeTable, name: str, pushes: Array
) -> NDArray[np.bool_]:
    """At each speed at which both determine a derivative, whether they have nothing in common."""
    here, there = one.index(name), two.index(name)
    pairs = [
        (row, place)
        for row, Fn in enumerate(one.Fn)
        for place, own in enumerate(two.Fn)
        if np.isclose(own, Fn, rtol=1e-3, equal_nan=True) and not _inside(name, Fn, pushes)
    ]
    (low, high), (below, above) = one.interval(), two.interval()
    found = []
    for row, place in pairs:
        ends = low[row, here], high[row, here], below[place, there], above[place, there]
        if np.all(np.isfinite(ends)):
            x, y = one.value[row, here], two.value[place, there]
            parted = ends[0] > ends[3] or ends[1] < ends[2]
            found.append(bool(parted and abs(x - y) > APART * max(abs(x), abs(y))))
    return np.array(found, dtype=np.bool_)


def _scattered(solution: Solution) -> Iterator[str]:
    """Channels whose runs scatter beyond any laboratory."""
    scatter = solution.between.scatter
    if scatter is None:
        return
    for channel in scatter.weights:
        found = dict(zip(RunEffects.KINDS, scatter.sizes(channel).tolist(), strict=True))
        if any(size > WORST[name] for name, size in found.items()):
            yield (
                f"Runs scatter as in no laboratory ({solution.between.in_words(channel)}): some "
                f"of them are of another quantity, unit or sign."
            )


def _massless(table: DerivativeTable) -> Iterator[str]:
    """Rows whose mass matrix, with the model's own inertia, is not positive."""
    if not all(name in table for name in MASS):
        return
    ship = table.ship
    for row, Fn in enumerate(table.Fn):
        known = {
            name: float(x)
            for name, x in zip(table.names, table.value[row], strict=True)
            if math.isfinite(x)
        }
        if all(name in known for name in MASS):
            added = AddedMass.of(known, ship=ship, water=table.water, convention=table.convention)
            sway, yaw = ship.mass - added.Yvdot, ship.Izz - added.Nrdot
            moment = ship.mass * ship.xG
            cross = (moment - added.Yrdot) * (moment - added.Nvdot)
            if not (min(ship.mass - added.Xudot, sway, yaw) > 0 and sway * yaw > cross):
                yield (
                    f"The mass matrix{at_froude(Fn)} is not positive: no ship with these added "
                    f"masses moves. Check the inertia, and what is said of the forces."
                )


def _list(names: Sequence[str]) -> str:
    """The first names, and how many more there are."""
    more = len(names) - TOLD
    return f"{', '.join(names[:TOLD])} and {more} more" if more > 0 else listed(names)
