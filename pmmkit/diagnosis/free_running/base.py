"""What is known of a model's values before free-running records are asked."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import DataError
from pmmkit.diagnosis.free_running.information import Forces, Information, WindowInformation
from pmmkit.effects import CATALOGUE
from pmmkit.identification import FreeRecord, Prior
from pmmkit.models import Model, Part, Sailing
from pmmkit.numerics import Array

# How large the forces are that nothing explains.


FLOOR: Final = 0.001
"""Unknown forces below this share of the rms force of a channel do not matter."""
MEMORIES: Final = (0.5, 1.5, 5.0)
"""Times over which they may hang together, in ship lengths over the speed."""
FACTORS: Final = (10.0, 4.0, 2.0, 1.4)
"""By which their sizes are varied, round by round."""
MOST: Final = 0.3
"""None is larger, over ½ρLdU² and ½ρL²dU²."""


def most_likely(
    information: Information,
    value: Callable[[WindowInformation], float],
    least: Array,
    begin: Forces | None = None,
    factors: Sequence[float] = FACTORS,
) -> tuple[Forces, float]:
    """Unknown forces of the size and memory that make records most probable, and how probable.

    least (f,).
    """
    told: dict[tuple[bytes, float], float] = {}  # a quarter is asked again
    at = cache(information.at_memory)

    def probability(forces: Forces) -> float:
        key = (forces.shares.tobytes(), forces.memory)
        if key not in told:
            told[key] = value(at(forces.memory).under(forces))
        return told[key]

    made = begin or Forces(shares=np.maximum(0.01, least), memory=MEMORIES[1])
    known = probability(made)
    for factor in factors:
        for i in range(len(least)):
            for f in (1.0 / factor, factor):
                while True:
                    shares = made.shares.copy()
                    shares[i] = min(max(shares[i] * f, least[i]), MOST)
                    if shares[i] == made.shares[i]:
                        break
                    other = Forces(shares=shares, memory=made.memory)
                    found = probability(other)
                    if found <= known:
                        break
                    made, known = other, found
        for memory in MEMORIES:
            if memory == made.memory:
                continue
            # Size and memory trade with each other: varied one by one they get stuck.
            root = math.sqrt(made.memory / memory)
            for scale in (1.0, root, 1.0 / root):
                shares = np.clip(scale * made.shares, least, MOST)
                other = Forces(shares=shares, memory=memory)
                found = probability(other)
                if found > known:
                    made, known = other, found
    return made, known


def usual_forces(model: Model, records: Sequence[FreeRecord]) -> Array:
    """Root mean square of the force of each channel over its unit, from rates of the heading.

    Surge force of the resistance, side force of m u r, moment of the inertia in a change of the
    yaw rate over a ship length; of roll that of the side force on a lever of a tenth of the
    draught.
    """
    words = ("X", "Y", "N", "K") if model.rolls else ("X", "Y", "N")
    squares = []
    for record in records:
        ship, unit = model.ship, record.force_units(model)
        pace = record.speed / ship.L
        rate = record.measured.get("r")
        if rate is None and "psi" in record.measured:
            rate = np.gradient(record.measured["psi"], record.t)
        if rate is None:
            raise DataError(f"Record {record.name!r} holds neither heading nor yaw rate.")
        r = rate[np.isfinite(rate)]
        size = math.sqrt(float(np.mean(r**2))) if len(r) else 0.0
        motion = {
            "u": np.array([record.speed]),
            "v": np.zeros(1),
            "r": np.array([size]),
            "udot": np.array([0.05 * record.speed * pace]),
            "vdot": np.zeros(1),
            "rdot": np.array([size * pace]),
        }
        force = ship.rigid_body_forces(motion)
        sizes = {name: abs(float(force[name][0])) for name in ("X", "Y", "N")}
        sizes["K"] = 0.1 * ship.d * sizes["Y"]
        squares.append(np.array([sizes[word] / unit[word] for word in words]) ** 2)
    shares: Array = np.maximum(np.sqrt(np.mean(squares, axis=0)), 1e-3)
    return shares


SPREAD: Final = 0.15
"""Largest share of their usual sizes by which the values of a model may be off."""
STEPS: Final = (0.0, 0.03, 0.1, 0.3, 1.0)
"""Shares of the spread that are weighed against each other, none of it among them."""
JITTER: Final = 1e-9


@dataclass(frozen=True, kw_only=True, eq=False)
class FreeBase:
    """Values that may move, and by how much.

    `names`: values of the model. `sizes (b,)`: usual size of each. `known (b + g, b + g)`:
    covariance that holds whatever the spread is, over the sizes; after the values, that of the
    coefficients of effects that the base has. `spreads (s,)`: standard deviations over the
    sizes that are weighed against each other, beside it. `open (b,)`: values that move by these
    too. `alone (b,)`: values that state an uncertainty of their own, without a covariance.
    """

    names: tuple[str, ...]
    sizes: Array
    known: Array
    spreads: Array
    open: NDArray[np.bool_]
    alone: NDArray[np.bool_]

    def within(self, count: int) -> FreeBase:
        """The same with the first, smallest spreads alone; the first is none."""
        return replace(self, spreads=self.spreads[:count])

    @property
    def held(self) -> FreeBase:
        """The same of which no value moves; coefficients of effects do."""
        known, own = self.known.copy(), len(self.names)
        known[:own] = known[:, :own] = 0.0
        return replace(self, known=known, spreads=np.zeros(1))

    @property
    def moves(self) -> NDArray[np.bool_]:
        """Which of all numbers move, at one of the spreads at least."""
        found = np.diagonal(self.known) > 0.0
        found[: len(self.open)] |= self.open & (np.max(self.spreads) > 0.0)
        return found

    @property
    def moving(self) -> FreeBase:
        """Those that move alone."""
        there, own = self.moves, self.moves[: len(self.names)]
        return replace(
            self,
            names=tuple(name for name, moves in zip(self.names, own, strict=True) if moves),
            sizes=self.sizes[own],
            known=self.known[np.ix_(there, there)],
            open=self.open[own],
            alone=self.alone[own],
        )

    def having(self, coefficients: int) -> FreeBase:
        """The same with effects of so many coefficients, each as wide as a candidate's."""
        width = len(self.known)
        known = np.eye(width + coefficients)
        known[:width, :width] = self.known
        return replace(self, known=known)

    def root(self, spread: float) -> Array:
        """Root (b + g, m) of the covariance at a spread, with a column for each of the m numbers
        that may move."""
        whole = self.known.copy()
        values = np.flatnonzero(self.open)
        whole[values, values] += spread**2
        moves = np.diagonal(whole) > 0.0
        scale = np.sqrt(np.diagonal(whole)[moves])
        correlation = whole[np.ix_(moves, moves)] / np.outer(scale, scale)
        covariance_root = np.zeros((len(whole), len(scale)))
        covariance_root[moves] = scale[:, None] * np.linalg.cholesky(
            correlation + JITTER * np.eye(len(scale))
        )
        return covariance_root


def idle(part: Part) -> bool:
    """Whether all that is uncertain of a part with a candidate of its own is zero."""
    own = [part.values.get(item.name) for item in part.known.parameters if item.uncertain]
    return "waves" in part.known.roles and not any(own)


def movable(model: Model) -> tuple[str, ...]:
    """Derivatives of hull, rudder and added mass, and of other parts the values that are uncertain
    with any ship, or that state how uncertain they are.

    A table of wave drift whose factors are zero waits to be asked for: it does not act, and no base
    moves it.
    """
    others = [
        f"{part.effect}.{item.name}"
        for part in model.parts.values()
        for item in part.known.parameters
        if item.name in part.values
        and not item.table
        and (item.uncertain or part.std.get(item.name, 0.0) > 0.0)
        and not idle(part)
    ]
    return (*model.derivatives, *others)


def base_of(
    model: Model, speed: float, *, spread: float = SPREAD, extrapolate: bool = False
) -> FreeBase:
    """The values of a model, how uncertain it states them, and a spread that records have to tell.

    A value of a part that states its uncertainty, measured or a guess, moves within that. The
    covariance of derivatives is that of one fit, of one form in one laboratory: the spread comes to
    it. speed [m/s].

    Examples
    --------
    >>> from pmmkit.models import load_model
    >>> found = base_of(load_model("kvlcc2-l7"), 1.179)
    >>> len(found.names), found.spreads.tolist()
    (25, [0.0, 0.0045, 0.015, 0.045, 0.15])
    """
    names = movable(model)
    own = Prior.of(model, names, speed, spread=dict.fromkeys(names, 1.0), extrapolate=extrapolate)
    usual = usual_sizes(model, speed)
    sizes = np.array(
        [max(size, usual.get(name, 0.0)) for name, size in zip(names, own.std, strict=True)]
    )
    stated = Prior.of(model, names, speed, spread=None, extrapolate=extrapolate)
    fitted = np.isin(names, model.covariance_names)
    alone = ~fitted & np.isin(names, own_uncertainties(model))
    there = fitted | alone
    known = np.where(np.outer(there, there), stated.covariance, 0.0) / np.outer(sizes, sizes)
    of_parts = np.array(["." in name for name in names])
    return FreeBase(
        names=names,
        sizes=sizes,
        known=known,
        spreads=np.round(spread * np.array(STEPS), 12),
        open=~there | (fitted & ~of_parts),
        alone=alone,
    )


def own_uncertainties(model: Model) -> list[str]:
    """Values that state an uncertainty of their own."""
    return [
        part.place(name)
        for part in model.parts.values()
        for name, std in part.std.items()
        if std > 0.0
    ]


def stated_base(prior: Prior) -> FreeBase:
    """A base that is known as it is stated, and no further."""
    sizes = prior.std
    return FreeBase(
        names=prior.names,
        sizes=sizes,
        known=prior.covariance / np.outer(sizes, sizes),
        spreads=np.zeros(1),
        open=np.zeros(len(sizes), bool),
        alone=np.zeros(len(sizes), bool),
    )


def usual_sizes(model: Model, speed: float) -> dict[str, float]:
    """Usual sizes of values by name, as the effects of the catalogue have them.

    A value of a model may be far smaller than it usually is, and be off by more than itself.
    """
    vessel = Sailing(model, speed)
    sizes: dict[str, float] = {}
    for effect in CATALOGUE.values():
        asked = effect.kind in ("terms", "freed") and effect.frees in ("", *model.parts)
        if not asked or effect.varies_with_speed:
            continue
        for move in vessel.moves(effect).values():
            for name, share in move.values.items():
                sizes[name] = max(sizes.get(name, 0.0), abs(share * move.typical))
    return sizes


def known_faults(model: Model, records: Sequence[FreeRecord]) -> tuple[str, ...]:
    """Names of the faults that a model's steps tell of records, each once."""
    titles = dict.fromkeys(record.campaign for record in records)
    return tuple(dict.fromkeys(name for x in titles for name in model.faults_of(x)))
