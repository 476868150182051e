"""Validation uncertainty of a captive run (ASME V&V 20, ITTC 7.5-03-01-01): what may differ.

U_V = 2 √(u_noise² + u_scatter² + u_stated² + u_model² + u_SN² + floor²); U_D is the measurement's
part of it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Any, Final

import numpy as np

from pmmkit.campaigns import Campaign, Rig, TypeB
from pmmkit.effects import Regressors
from pmmkit.inference import Propagated, Stencil, std_along
from pmmkit.numerics import Array
from pmmkit.reduction import View, altered
from pmmkit.simulation import Spread
from pmmkit.validation.prediction import Forces, Predictor
from pmmkit.validation.statistics import squares_of

Share = Mapping[str, Array]
"""Standard uncertainty of each harmonic by channel [N, N m]."""
SHARES: Final = ("noise", "scatter", "stated", "model", "numerical", "floor")
"""What a validation uncertainty is made of."""
OF_MEASUREMENT: Final = ("noise", "scatter", "stated", "numerical")
"""What of it is the measurement's."""


def stated_share(
    view: View,
    rig: Rig,
    forces: Forces,
    sources: Iterable[TypeB],
    water_rho: float,
    predicted: Share,
) -> dict[str, Array]:
    """What the stated uncertainties do to the difference of prediction and measurement.

    water_rho [kg/m³]; predicted (m,).
    """
    read = rig.as_read(view.force, view.run, view.motion, view.project)
    causes, changes = [], []
    for source in sources:
        changes.append(_change(view, rig, forces, source, water_rho, predicted, read))
        causes.append(source.common)
    zero = np.zeros(view.rows)
    return {
        name: Propagated(
            factors=tuple(change.get(name, zero)[None] for change in changes), causes=tuple(causes)
        ).std
        if changes
        else zero
        for name in view.force
    }


def _change(
    view: View, rig: Rig, forces: Forces, source: TypeB, rho: float, predicted: Share, read: Share
) -> Share:
    """Change of prediction less measurement by one standard uncertainty of one source."""
    changed = altered(source, view.run, rig, labels=view.labels, force=read, rho=rho)
    if changed is None:
        return {}
    if changed.density:
        return {name: changed.density * x for name, x in predicted.items()}
    if changed.run is not view.run:
        # The nominal motion with another setting: prediction, less the inertia on the balance.
        paths = changed.nominal_beside(view.run, view.labels)
        before, after = (
            _less(forces(motion, t), rig.inertia_inside(changed.run, motion))
            for motion, t, _ in paths
        )
        projection = paths[0][-1]
        return {name: projection @ (after[name] - before[name]) for name in view.force}
    if changed.rig is not rig:
        return _by_rig(view, rig, forces, changed.rig)
    return {name: -x for name, x in changed.force.items()}


def _by_rig(view: View, rig: Rig, forces: Forces, other: Rig) -> dict[str, Array]:
    """The motion as measured with another rig: prediction, less the inertia on the balance."""
    shift = other.motion_x - rig.motion_x
    moved = view.motion.moved_aft(shift)
    change = _less(rig.inertia_inside(view.run, view.motion), other.inertia_inside(view.run, moved))
    if shift:
        here, there = (forces(motion, view.instants) for motion in (view.motion, moved))
        change = {name: x + (there[name] - here[name]) for name, x in change.items()}
    return {name: view.project(change[name]) for name in view.force}


def _less(first: Share, second: Share) -> dict[str, Array]:
    return {name: x - second[name] for name, x in first.items()}


def stated_spread(predictor: Predictor, speed: float) -> Spread | None:
    """How the values of a model differ by what it states, at a speed [m/s]; None of nothing."""
    if not predictor.model.is_uncertain:
        return None
    return Spread.of(predictor.model, speed, extrapolate=predictor.extrapolate)


def model_share(view: View, predictor: Predictor, known: Spread | None) -> dict[str, Array]:
    """Standard uncertainty of the prediction from what a model states of its values."""
    model = predictor.model
    zero = {name: np.zeros(view.rows) for name in view.force}
    if known is None:
        return zero
    jacobian = {name: np.zeros((view.rows, len(known.names))) for name in view.force}
    terms = [i for i, name in enumerate(known.names) if "." not in name and name[0] in view.force]
    for channel in view.force:
        own = [i for i in terms if known.names[i][0] == channel]
        if own:
            jacobian[channel][:, own] = view.project(
                Regressors.at(
                    [known.names[i] for i in own],
                    view.motion,
                    ship=model.ship,
                    water=model.water,
                    convention=model.convention,
                    approach_speed=view.speed,
                ).columns
            )
    others = [i for i, name in enumerate(known.names) if "." in name]
    if others:
        steps = np.eye(len(known.names))[others]
        ships = known.independent.of_normal(Stencil().points(np.zeros(len(known.names)), steps))
        said = [
            _of_ship(view, predictor, known, values, i)
            for i, values in zip(np.repeat(others, 2), ships, strict=True)
        ]
        for channel in view.force:
            changes = Stencil().differences(np.stack([forces[channel] for forces in said]))
            jacobian[channel][:, others] = (changes / known.std[others, None]).T
    C = known.covariance
    return {name: std_along(J, C) for name, J in jacobian.items()}


def _of_ship(view: View, predictor: Predictor, known: Spread, values: Array, place: int) -> Share:
    """Harmonics of the forces on a ship of which one value of a part is another."""
    effect, _, name = known.names[place].rpartition(".")
    part = predictor.model.parts[effect]
    mean, other = known.mean[place], values[place]
    own = part.values[name]
    moved: Any = float(other)
    if isinstance(own, tuple):
        moved = tuple(x * other / mean if mean else x + other for x in own)
    model = replace(
        predictor.model,
        parts=MappingProxyType(
            {
                **predictor.model.parts,
                effect: replace(part, values=MappingProxyType({**part.values, name: moved})),
            }
        ),
    )
    forces = replace(predictor, model=model).forces(view)
    return {x: view.project(force) for x, force in forces(view.motion, view.instants).items()}


def scales(views: Sequence[View]) -> dict[str, float]:
    """Root mean square over the runs of the rms force over U², by channel [N/(m/s)²]."""
    found: dict[str, list[float]] = {}
    for view in views:
        for name, force in view.force.items():
            found.setdefault(name, []).append(rms_of(force, view.labels) / view.speed**2)
    return {name: float(np.sqrt(np.mean(np.square(sizes)))) for name, sizes in found.items()}


def rms_of(harmonics: Array, labels: Sequence[str]) -> float:
    """Root mean square over time of what harmonics describe.

    harmonics (k,).

    Examples
    --------
    >>> round(rms_of(np.array([2.0, 4.0, 4.0]), ("C0", "C1", "S1")), 4) == round(20**0.5, 4)
    True
    """
    return float(np.sqrt(squares_of(labels) @ harmonics**2))


def sources_of(campaign: Campaign, *, repeated: bool) -> tuple[TypeB, ...]:
    """Stated uncertainties that count: where runs are repeated, only those that all runs share."""
    return tuple(item for item in campaign.uncertainty if item.shared or not repeated)
