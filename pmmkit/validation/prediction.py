"""Forces that a model predicts along the motion of a captive run."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Final

import numpy as np

from pmmkit.base import ModelError
from pmmkit.campaigns import Campaign
from pmmkit.conventions import Ship, Water
from pmmkit.effects import State
from pmmkit.equations import prepare
from pmmkit.models import Model, Part, scaled
from pmmkit.numerics import Array
from pmmkit.reduction import RunViews, View

Forces = Callable[[State, Array], dict[str, Array]]
"""From the motion of midship and its instants [s] to forces of the water by channel [N, N m]."""
SAME_LENGTH: Final = 1e-3


@dataclass(frozen=True, kw_only=True, eq=False)
class Predictor:
    """A model as it stands in the towing tank: what `RunViews` ask for forces.

    `model`: at the scale of the tests, in their water, with the parts that the tests hold.
    `extrapolate`: allow speeds outside the range of the model's values. `notes`: what was done
    to the model.
    """

    model: Model
    extrapolate: bool
    notes: tuple[str, ...]

    @property
    def ship(self) -> Ship:
        """The model that was tested."""
        return self.model.ship

    @property
    def water(self) -> Water:
        """The water of the tank."""
        return self.model.water

    def along(self, runs: RunViews, motion: State, speed: Array) -> dict[str, Array]:
        """All harmonics of the forces that it predicts in views, one below the other, if the model
        and its carriage (n,) went so."""
        parts: dict[str, list[Array]] = {}
        for view, at in zip(runs.views, runs.samples, strict=True):
            forces = self.forces(view, float(speed[at.start]))(motion.at(at), view.instants)
            for name, force in forces.items():
                if name in view.force:
                    parts.setdefault(name, []).append(view.harmonics(force))
        return {name: np.concatenate(own) for name, own in parts.items()}

    def forces(self, view: View, speed: float | None = None) -> Forces:
        """What predicts the forces of a run; a propeller that does not turn in it exerts none.

        speed [m/s].
        """
        speed = view.speed if speed is None else speed
        turning = bool(np.any(view.motion.rps))
        parts = self.model.parts
        hull = {name for name, part in parts.items() if not part.known.drives}
        if turning or len(hull) == len(self.model.parts):
            return self._of(set(self.model.parts), speed)
        towed = {name for name in hull if not parts[name].known.steers}
        if not any("n" in parts[x].known.needs for x in hull if parts[x].known.steers):
            return self._of(hull, speed)
        whole, still, bare = (
            self._of(set(self.model.parts), speed),
            self._of({*towed, *(set(self.model.parts) - hull)}, speed),
            self._of(towed, speed),
        )

        def forces(motion: State, t: Array) -> dict[str, Array]:
            with_both, with_screw, alone = whole(motion, t), still(motion, t), bare(motion, t)
            return {name: x - with_screw[name] + alone[name] for name, x in with_both.items()}

        return forces

    def _of(self, names: set[str], speed: float) -> Forces:
        """Forces of some of the parts."""
        parts = {name: part for name, part in self.model.parts.items() if name in names}
        model = replace(
            self.model, parts=MappingProxyType(parts), covariance=None, covariance_names=()
        )
        ready = prepare(model, speed, extrapolate=self.extrapolate, sails=False)

        def forces(motion: State, t: Array) -> dict[str, Array]:
            given = history_of(motion)
            return ready.water_forces(given | ready.repeating_states(given, t))

        return forces


def history_of(motion: State) -> dict[str, Array]:
    """A motion by the names of the kernel."""
    return {
        name: getattr(motion, name)
        for name in ("u", "v", "r", "p", "phi", "udot", "vdot", "rdot", "pdot", "delta")
    } | {"n": motion.rps}


def _in_the_air(part: Part) -> bool:
    """Whether a towed model does not feel a part: its revolutions are given, the air is still."""
    return bool({"wind", "shaft"} & set(part.known.roles))


def in_the_tank(model: Model, campaign: Campaign, *, extrapolate: bool = False) -> Predictor:
    """A model brought to the scale and the water of captive tests."""
    made, notes = at_the_scale_of(model, campaign.ship)
    turning = any(run.settings.propeller_rps for run in campaign)
    ruddered = bool(campaign.rudder) or any(run.settings.largest_rudder for run in campaign)
    left: list[str] = []
    for name, part in made.parts.items():
        driving, steering = part.known.drives, part.known.steers
        idle = (driving and not turning and not ruddered) or (steering and not ruddered)
        if idle or _in_the_air(part):
            left.append(name)
    if told := [name for name in left if not _in_the_air(made.parts[name])]:
        notes.append(f"The tests have no {' and no '.join(told)}: left out of the prediction.")
    kept = {name: part for name, part in made.parts.items() if name not in left}
    return Predictor(
        model=replace(
            _without_stale_covariance(made, kept),
            parts=MappingProxyType(kept),
            water=campaign.water,
        ),
        extrapolate=extrapolate,
        notes=tuple(notes),
    )


def _without_stale_covariance(model: Model, kept: Mapping[str, Part]) -> Model:
    """The model with the covariance of what is left of it (the marginal one)."""
    values = {part.place(name) for part in kept.values() for name in part.values}
    held = [name in values for name in model.covariance_names]
    if model.covariance is None or all(held):
        return model
    if not any(held):
        return replace(model, covariance=None, covariance_names=())
    own = np.tile(held, max(len(model.Fn), 1))
    names = tuple(name for name in model.covariance_names if name in values)
    return replace(model, covariance=model.covariance[np.ix_(own, own)], covariance_names=names)


def at_the_scale_of(model: Model, ship: Ship) -> tuple[Model, list[str]]:
    """A model at the length of a ship by Froude's law, and what was done, in words."""
    apart = [
        f"{name} {own:.4f} against {theirs:.4f}"
        for name, (own, theirs) in model.ship.form_apart(ship).items()
    ]
    if apart:
        raise ModelError(
            f"Model {model.name!r} is of another ship than the tests ({ship.name}): "
            f"{', '.join(apart)}. Compare tests with a model of their own hull and draught."
        )
    ratio = ship.L / model.ship.L
    if abs(ratio - 1.0) <= SAME_LENGTH:
        return model, []
    note = (
        f"The model (L = {model.ship.L:g} m) was brought to the tests' scale (L = {ship.L:g} m) by "
        f"Froude's law, without correction of friction or wake."
    )
    return scaled(model, ship.L), [note]
