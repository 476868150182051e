"""What may be wrong with a run or with all: the faults of the catalogue, as checks ask for them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from pmmkit.campaigns.motion.kinematics import motion_at_phase, move_motion
from pmmkit.campaigns.run import Run
from pmmkit.checks.agreement.records import Records
from pmmkit.checks.agreement.rows import Group, phases
from pmmkit.effects.catalogue import catalogue
from pmmkit.effects.effect import Effect
from pmmkit.effects.faults.fault import shown_by, slopes, suspicion
from pmmkit.effects.seen import Forces, Observed
from pmmkit.effects.suspect import Suspect
from pmmkit.numerics import Array


@dataclass(frozen=True, kw_only=True)
class Suspected(Suspect):
    """A suspect with the fault that it is a form of.

    Parameters
    ----------
    effect : Effect
        What it does to records.
    """

    effect: Effect

    @property
    def cause(self) -> str:
        """The word by which findings know it: that of the fault, or of the slip itself."""
        return self.name if self.slip else self.effect.name

    def concerns(self, run: Run) -> bool:
        """Whether it can be asked of a run."""
        return bool(run.test) and self.applies(run.kind_of_test)

    def histories(self, records: Records, value: float) -> Array:
        """What each parameter would multiply in the records, (n, 32, 3, p), as told if nothing."""
        told = records.histories
        if self.unknown:
            return told
        shown = shown_by(self.effect, records, self.at(value))
        return records.as_histories(shown, told, self._touched(records.group))

    def column(self, valued: Records, value: float) -> Array:
        """Harmonics (n, 3, 7) of what its unknown size multiplies, over its standard deviation."""
        slope = slopes(self.effect, valued, self.at(value), [self.unknown])
        shown = valued.as_histories(
            {name: self.spread(value) * own for name, (own,) in slope.items()},
            np.zeros(valued.histories.shape[:-1]),
            self._touched(valued.group),
        )
        return valued.group.design(shown[..., None])[..., 0]

    def _touched(self, group: Group) -> NDArray[np.bool_]:
        return np.array([self.concerns(item.run) for item in group.summaries])


def suspects(effects: Iterable[Effect] | None = None) -> tuple[Suspected, ...]:
    """All forms of the faults of the catalogue, or of some effects, for which the checks ask.

    Examples
    --------
    >>> [item.name for item in suspects([catalogue()["fault_misalignment"]])]
    ['drift', 'drift as set']
    """
    every = catalogue().values() if effects is None else effects
    return tuple(
        Suspected(**{part.name: getattr(form, part.name) for part in fields(Suspect)}, effect=own)
        for own in every
        for form in own.suspects
    )


def record_of(run: Run, reference_x: float) -> Suspected:
    """That a record is that of another run, or of one with its settings.

    Parameters
    ----------
    run : Run
        The other.
    reference_x : float
        Point to which its motion refers, forward of midship [m].
    """
    form = Suspect(
        name="record of another run",
        says=lambda _: (
            f"its file is the record of {run.id} ({', '.join(run.settings.words)}), or of a run "
            f"with those settings: files or settings are exchanged"
        ),
        remedy="Look which file belongs to which run.",
        scope="one",
        slip=True,
    )

    def acts(records: Observed, at: Mapping[str, float]) -> Forces:
        del at
        return records.along(move_motion(motion_at_phase(run, phases()), reference_x))

    own = suspicion("slip_exchanged_records", "slips", "The record of another run.", acts, (form,))
    return suspects([own])[0]
