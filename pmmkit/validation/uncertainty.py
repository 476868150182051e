"""Validation uncertainty of a captive run (ASME V&V 20, ITTC 7.5-03-01-01): what may differ."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np

from pmmkit.campaigns.motion.kinematics import move_motion, nominal_motion
from pmmkit.campaigns.run import Campaign, TypeB
from pmmkit.effects.hull import regressors
from pmmkit.numerics import Array, projector
from pmmkit.observations.inertia import Rig, inertia_force
from pmmkit.observations.views import View
from pmmkit.signals import design_matrix
from pmmkit.validation.prediction import Forces, Predictor

Share = Mapping[str, Array]
"""Standard uncertainty of each harmonic by channel [N, N m]."""
COVERAGE: Final = 2.0
"""Expanded uncertainty over standard uncertainty."""
SHARES: Final = ("noise", "scatter", "stated", "model", "numerical", "floor")
"""What a validation uncertainty is made of."""
GRID: Final = 120
"""Instants of a cycle at which a changed setting is felt."""
_RIG: Final = {"mass": "mass", "Izz": "Izz", "xG": "xG"}
_SETTINGS: Final = (
    "speed",
    "drift",
    "heel",
    "rudder",
    "propeller_rps",
    "period",
    "amplitude",
    "yaw_amplitude",
    "phase",
    "yaw_rate",
    "radius",
)


def stated_share(
    view: View,
    rig: Rig,
    forces: Forces,
    sources: Iterable[TypeB],
    water_rho: float,
    predicted: Share,
) -> dict[str, Array]:
    """What the stated uncertainties do to the difference of prediction and measurement.

    Parameters
    ----------
    view : View
        The run.
    rig : Rig
        Inertia and reference points.
    forces : callable
        Prediction along a motion.
    sources : iterable of TypeB
        Stated standard uncertainties.
    water_rho : float
        Density [kg/m³].
    predicted : mapping of channel to array (m,)
        Predicted harmonics.

    Returns
    -------
    dict of channel to array (m,)
        Standard uncertainties, sources added in squares.
    """
    square = {name: np.zeros(view.rows) for name in view.force}
    for source in sources:
        change = _change(view, rig, forces, source, water_rho, predicted)
        for name, moved in change.items():
            if name in square:
                square[name] = square[name] + moved**2
    return {name: np.sqrt(x) for name, x in square.items()}


def _change(
    view: View, rig: Rig, forces: Forces, source: TypeB, rho: float, predicted: Share
) -> dict[str, Array]:
    """Change of the difference by one standard uncertainty of one source."""
    if source.name.endswith("_gauge"):
        return _by_gauge(view, rig, source)
    if source.name == "rho":
        share = source.std if source.relative else source.std / rho
        return {name: share * predicted[name] for name in view.force}
    if source.name == "moment_reference_x" and "Y" in view.force:
        return {"N": source.std * view.force["Y"]}
    if source.name in _RIG:
        if view.run.forces != "balance":
            return {}
        value = getattr(rig, _RIG[source.name])
        heavier = replace(rig, **{_RIG[source.name]: _stepped(value, source)})
        before, after = inertia_force(view.motion, rig), inertia_force(view.motion, heavier)
        return {name: view.project(before[name] - after[name]) for name in view.force}
    return _by_setting(view, rig, forces, source)


def _by_gauge(view: View, rig: Rig, source: TypeB) -> dict[str, Array]:
    channel = source.name[0]
    if channel not in view.force:
        return {}
    step = np.zeros(view.rows)
    if source.relative:
        step = source.std * view.force[channel]
    elif "C0" in view.labels:
        step[view.labels.index("C0")] = source.std
    moved = {channel: step}
    if channel == "Y":
        moved |= {
            name: arm * step for name, arm in (("N", rig.moment_x), ("K", -rig.moment_z)) if arm
        }
    return moved


def _by_setting(view: View, rig: Rig, forces: Forces, source: TypeB) -> dict[str, Array]:
    """The nominal motion with another setting: prediction, less the inertia on the balance."""
    settings = view.run.settings
    value = getattr(settings, source.name) if source.name in _SETTINGS else None
    if value is None:
        return {}
    changed: dict[str, Any] = {source.name: _stepped(value, source)}
    runs = (view.run, view.run.with_(settings=replace(settings, **changed)))
    theta: Array = np.zeros(1)
    if view.run.dynamic:
        theta = np.arange(GRID, dtype=np.float64) * (2 * math.pi / GRID)
    order = max((int(label[1:]) for label in view.labels), default=0)
    rows = [_place(label) for label in view.labels]
    projection = (
        projector(design_matrix(theta, order))[rows] if view.run.dynamic else np.ones((1, 1))
    )
    found = []
    for run in runs:
        omega = run.settings.omega or 1.0
        motion = move_motion(
            nominal_motion(run, (theta - run.settings.phase) / omega), rig.motion_x
        )
        force = forces(motion, theta / omega)
        if run.forces == "balance":
            inertia = inertia_force(motion, rig)
            force = {name: x - inertia[name] for name, x in force.items()}
        found.append(force)
    return {name: projection @ (found[1][name] - found[0][name]) for name in view.force}


def _place(label: str) -> int:
    """Where a harmonic stands among C0, C1, S1, C2, S2 …"""
    order = int(label[1:])
    return 0 if order == 0 else 2 * order - (label[0] == "C")


def _stepped(value: float, source: TypeB) -> float:
    return value * (1 + source.std) if source.relative else value + source.std


def model_share(view: View, predictor: Predictor, Fn: float) -> dict[str, Array]:
    """Standard uncertainty of the prediction from the covariance of a model's derivatives.

    Parameters
    ----------
    view : View
        The run.
    predictor : Predictor
        The model.
    Fn : float
        Froude number of the run.

    Returns
    -------
    dict of channel to array (m,)
        Zero where the model states none; what it does not know of a derivative counts as nothing.
    """
    model = predictor.model
    zero = {name: np.zeros(view.rows) for name in view.force}
    if model.covariance is None:
        return zero
    weights = np.array(model.weights(Fn, extrapolate=predictor.extrapolate) if model.Fn else (1.0,))
    n = len(model.covariance_names)
    blocks = model.covariance.reshape(len(weights), n, len(weights), n)
    known = np.nan_to_num(np.einsum("i,iajb,j->ab", weights, np.nan_to_num(blocks), weights))
    for channel in view.force:
        own = [i for i, name in enumerate(model.covariance_names) if name[0] == channel]
        if own:
            design = view.project(
                regressors(
                    [model.covariance_names[i] for i in own],
                    view.motion,
                    ship=model.ship,
                    water=model.water,
                    convention=model.convention,
                    approach_speed=view.speed,
                )
            )
            variance = np.einsum("ij,jk,ik->i", design, known[np.ix_(own, own)], design)
            zero[channel] = np.sqrt(np.maximum(variance, 0.0))
    return zero


def scales(views: Sequence[View]) -> dict[str, float]:
    """Root mean square over the runs of the rms force over U², by channel [N/(m/s)²]."""
    found: dict[str, list[float]] = {}
    for view in views:
        for name, force in view.force.items():
            found.setdefault(name, []).append(rms_of(force, view.labels) / view.speed**2)
    return {name: float(np.sqrt(np.mean(np.square(sizes)))) for name, sizes in found.items()}


def rms_of(harmonics: Array, labels: Sequence[str]) -> float:
    """Root mean square over time of what harmonics describe.

    Examples
    --------
    >>> round(rms_of(np.array([2.0, 4.0, 4.0]), ("C0", "C1", "S1")), 4) == round(20**0.5, 4)
    True
    """
    weights = np.array([1.0 if label == "C0" else 0.5 for label in labels])
    return float(np.sqrt(weights @ harmonics**2))


def sources_of(campaign: Campaign, *, repeated: bool) -> tuple[TypeB, ...]:
    """Stated uncertainties that count: where runs are repeated, only those that all runs share."""
    return tuple(item for item in campaign.uncertainty if item.shared or not repeated)
