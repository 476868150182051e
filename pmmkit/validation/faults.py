"""What the faults of a laboratory, as a model's steps tell them, do to captive runs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from pmmkit.effects.catalogue import catalogue
from pmmkit.effects.faults.fault import slopes
from pmmkit.effects.state import State
from pmmkit.models.step import Step
from pmmkit.numerics import Array
from pmmkit.observations.seen import Seen
from pmmkit.observations.views import View
from pmmkit.ship import Ship, Water
from pmmkit.validation.prediction import Predictor


@dataclass(frozen=True, kw_only=True, eq=False)
class InTheTank:
    """A model as what predicts the forces of a run; `observations.seen.Expects` says the rest."""

    predictor: Predictor
    turning: bool

    @property
    def ship(self) -> Ship:
        """The model that was tested."""
        return self.predictor.model.ship

    @property
    def water(self) -> Water:
        """The water of the tank."""
        return self.predictor.model.water

    def expected(self, view: View) -> dict[str, Array]:
        """All harmonics of the forces that the model predicts in a view [N, N m]."""
        return self.along(view, view.motion, view.speed)

    def along(self, view: View, motion: State, speed: float) -> dict[str, Array]:
        """The same if the model, or its carriage, went otherwise."""
        forces = self.predictor.forces(speed, turning=self.turning)(motion, view.instants)
        return {name: view.harmonics(x) for name, x in forces.items() if name in view.force}


def sizes_told(steps: Mapping[str, Step]) -> dict[str, tuple[float, ...]]:
    """Sizes of the faults that steps tell, as the coefficients of the effects stand.

    Parameters
    ----------
    steps : mapping of str to Step
        The faults, as `faults_of` gives them. One that each run draws for itself says nothing of
        another run, and one whose step has no sizes nothing at all: neither is among them.
    """
    found = {}
    for name, step in steps.items():
        effect = catalogue()[name]
        labels = [item.name for item in effect.coefficients]
        if effect.acts is not None and not effect.each_run and set(labels) <= {*step.coefficients}:
            found[name] = tuple(float(step.coefficients[x]) for x in labels)  # type: ignore[arg-type]
    return found


def shown_too_much(
    view: View, predictor: Predictor, steps: Mapping[str, Step], *, turning: bool
) -> dict[str, Array]:
    """Harmonics that a run shows beside the forces of the water, by channel [N, N m].

    Parameters
    ----------
    view : View
        The run.
    predictor : Predictor
        The model in the tank.
    steps : mapping of str to Step
        The faults, as `faults_of` gives them; those of `sizes_told` count.
    turning : bool
        Whether the propeller turns.
    """
    seen = Seen(view, InTheTank(predictor=predictor, turning=turning))
    found: dict[str, Array] = {}
    for name, sizes in sizes_told(steps).items():
        effect = catalogue()[name]
        at = {effect.nonlinear.name: steps[name].value or 0.0} if effect.nonlinear else {}
        shown = slopes(effect, seen, at, list(effect.typical))
        for channel, own in shown.items():
            for size, column in zip(sizes, own, strict=True):
                found[channel] = found.get(channel, 0.0) + size * column
    return found
