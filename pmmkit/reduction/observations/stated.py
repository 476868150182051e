"""What a stated standard uncertainty does to a run: the one description of how each enters.

An error of a gauge or of the point of the moments changes the force of the water at midship; an
error of the density changes what a model makes of every motion; an error of the rig or of a setting
makes another run of it, whose inertia and motion differ. Reduction and comparison ask here.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Final

import numpy as np

from pmmkit.campaigns import Rig, Run, TypeB
from pmmkit.effects import State
from pmmkit.numerics import Array, projector
from pmmkit.reduction.observations.prepare import one_cycle, places_of
from pmmkit.signals import design_matrix

RIG: Final = MappingProxyType(
    {"mass": "mass", "Izz": "Izz", "xG": "xG", "motion_reference_x": "motion_x"}
)
"""Where a rig holds what is stated of it."""
INERTIA: Final = frozenset({"mass", "Izz", "xG"})
StatedMotion = tuple[State, Array, Array]
"""Motion of midship, its instants (n,) [s], and the projection (m, n) onto m harmonics."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Altered:
    """A run with one standard uncertainty of error.

    `run`: with its settings as they would be. `rig`: as it would be. `force (m,)`: what is
    added to the harmonics of the force of the water at midship [N, N m]. `density`: share by
    which all that a model makes of a motion grows. `other_hull`: whether the length of the hull
    differs, by which all is made non-dimensional.
    """

    run: Run
    rig: Rig
    force: Mapping[str, Array] = field(default_factory=lambda: MappingProxyType({}))
    density: float = 0.0
    other_hull: bool = False

    def nominal_beside(
        self, run: Run, labels: Sequence[str]
    ) -> tuple[tuple[State, Array, Array], tuple[State, Array, Array]]:
        """The nominal motion of a run with its own settings, and with those here, at one phase."""
        phase = run.settings.phase
        return (
            nominal_path(run, self.rig, labels, phase),
            nominal_path(self.run, self.rig, labels, phase),
        )


def acts(source: TypeB, run: Run, channels: Collection[str]) -> bool:
    """Whether an error of a source changes a run of which some channels are measured."""
    name = source.name
    if source.kind.channels:
        return set(source.kind.channels) <= set(channels)
    if source.kind.of == "setting":
        return run.settings.value(name) is not None
    if name == "moment_reference_x":
        return {"Y", "N"} <= set(channels)
    return name not in INERTIA or run.forces == "balance"


def idle(sources: Iterable[TypeB], runs: Sequence[tuple[Run, Collection[str]]]) -> tuple[str, ...]:
    """A sentence on the sources that change none of the runs, if there are any.

    Parameters
    ----------
    sources : iterable of TypeB
        What is stated.
    runs : sequence of (Run, collection of str)
        The runs with their measured channels.
    """
    keys = dict.fromkeys(
        source.kind.key
        for source in sources
        if not any(acts(source, run, channels) for run, channels in runs)
    )
    if not keys:
        return ()
    return (
        f"No run feels what [uncertainty] states of {', '.join(keys)}: it counts nowhere in this.",
    )


def altered(
    source: TypeB,
    run: Run,
    rig: Rig,
    *,
    labels: Sequence[str],
    force: Mapping[str, Array],
    rho: float,
) -> Altered | None:
    """A run as it would be with one standard uncertainty of error.

    Parameters
    ----------
    source : TypeB
        What is uncertain.
    run, rig : Run, Rig
        As they are taken to be.
    labels : sequence of str (m,)
        C0, C1, S1 …
    force : mapping of channel to array (m,)
        Harmonics on which a gain acts [N, N m].
    rho : float
        Density of the water [kg/m³].

    Returns
    -------
    Altered or None
        None where the source does not act on this run.
    """
    if not acts(source, run, force):
        return None
    name = source.name
    if source.kind.channels:
        channel, *others = source.kind.channels
        step = (
            source.std * np.nan_to_num(force[others[0]])
            if others
            else _gauge_step(source, labels, force[channel])
        )
        more = rig.moments_of_sway(step) if channel == "Y" else {}
        return Altered(run=run, rig=rig, force={channel: step, **more})
    if source.kind.of == "water":
        share = source.std if source.relative else source.std / rho
        return Altered(run=run, rig=rig, density=share)
    if source.kind.of == "hull":
        return Altered(run=run, rig=rig, other_hull=True)
    if source.kind.of == "setting":
        moved_to = source.moved(run.settings.value(name) or 0.0)
        return Altered(run=run.with_(settings=run.settings.with_(name, moved_to)), rig=rig)
    if name == "moment_reference_x":
        arm = source.std * (rig.moment_x if source.relative else 1.0)
        return Altered(run=run, rig=rig, force={"N": arm * np.nan_to_num(force["Y"])})
    moved = {RIG[name]: source.moved(getattr(rig, RIG[name]))}
    return Altered(run=run, rig=replace(rig, **moved))


def _gauge_step(source: TypeB, labels: Sequence[str], force: Array) -> Array:
    """A gain acts on all harmonics, a zero error on the mean."""
    if source.relative:
        return source.std * np.nan_to_num(force)
    return np.array([source.std if label == "C0" else 0.0 for label in labels])


def nominal_path(
    run: Run, rig: Rig, labels: Sequence[str], phase: float | None = None
) -> StatedMotion:
    """The motion that the settings of a run say: one cycle, or one instant."""
    omega = run.settings.omega
    theta: Array = np.zeros(1)
    projection: Array = np.ones((1, 1))
    if run.dynamic and omega:
        theta, order = one_cycle(), max(int(label[1:]) for label in labels)
        projection = projector(design_matrix(theta, order))[places_of(labels)]
    t = (theta - (run.settings.phase if phase is None else phase)) / (omega or 1.0)
    motion = run.nominal_motion(t).moved_aft(rig.motion_x)
    return motion, theta / (omega or 1.0), projection
