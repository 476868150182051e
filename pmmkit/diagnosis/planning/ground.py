"""What a plan stands on: runs made and possible runs, seen with one base and one noise."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Final

import numpy as np

from pmmkit.base import DataError
from pmmkit.campaigns import Campaign
from pmmkit.conventions import Structure
from pmmkit.diagnosis.captive.base import CaptiveBase
from pmmkit.diagnosis.captive.candidate import Candidate, no_such_effect
from pmmkit.diagnosis.captive.diagnose import captive_system, derivatives_of, standing
from pmmkit.diagnosis.captive.evidence import best_blocks
from pmmkit.diagnosis.captive.refit import eligible, written_in
from pmmkit.diagnosis.captive.system import System, channels_of
from pmmkit.diagnosis.planning.information import (
    Reduced,
    RunInformation,
    WhitenedRows,
    drawn_once,
    known,
    rows_of,
)
from pmmkit.diagnosis.planning.options import Limits, Option, options_of
from pmmkit.diagnosis.planning.planned import (
    NoiseOf,
    base_of,
    measured_noise,
    planned_views,
    stated_noise,
    with_names,
)
from pmmkit.diagnosis.planning.separation import Likely, UsualEffects, likely, usual
from pmmkit.effects import Effect
from pmmkit.inference import RunEffects
from pmmkit.models import Model
from pmmkit.numerics import Array
from pmmkit.reduction import FLOOR, View, columns_of

Asked = Model | str | Path | Sequence[str] | Structure
CHANNELS: Final = ("X", "Y", "N")
TWICE: Final = 2
"""Runs that are asked for at a speed at which none is made."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Ground:
    """Runs made and runs that could be made, and what these would tell of effects.

    `rows`: of all of them. `made`: ids of the runs that are made. `options`: runs that could be
    made, by their id among the rows. `candidates`: effects and faults by name. `given`: effects
    that the base has beside its derivatives. `system`: of the runs that are made, as a
    diagnosis asks it.
    """

    rows: WhitenedRows
    made: tuple[str, ...]
    options: Mapping[str, Option]
    candidates: Mapping[str, Candidate]
    given: tuple[str, ...] = ()
    system: System | None = None

    def is_new_speed(self, speed: float) -> bool:
        """Whether no run is made at a speed, beside others that are made."""
        made = self.system.views if self.system is not None else ()
        return bool(made) and all(abs(view.speed - speed) > 1e-3 * speed for view in made)

    def known(self) -> RunInformation:
        """What the runs made tell."""
        return known(self.rows, self.made)

    @cached_property
    def reduced(self) -> Reduced:
        """What they say of the candidates, whatever base and floor are."""
        return self.known().reduced()

    @cached_property
    def usual(self) -> UsualEffects:
        """Effects at their usual sizes."""
        return usual(self.rows)

    @property
    def names(self) -> tuple[str, ...]:
        """Effects that take part."""
        return self.usual.names

    def check(self, name: str) -> str:
        """What settles an effect at the bench or on the rig."""
        return self.candidates[name].check

    def least(self, option: Option, /) -> int:
        """Twice at a new speed: one run would decide alone there, and may be wrong."""
        return TWICE if self.is_new_speed(option.settings.speed) else 1

    def likely(self, names: Sequence[str]) -> tuple[Likely, ...]:
        """A set of effects as the runs made leave it likely."""
        return likely(self.reduced, names)

    def added(self, run: str, times: int) -> Array:
        """What a run adds, the base refitted."""
        return self.reduced.added(run, times)

    def signals(self, run: str | None = None, times: int = 1) -> Array:
        """Squared signal over noise of each effect after a run."""
        before = self.usual.signals(self.reduced.normal.information)
        if run is None:
            return before
        more: Array = np.sum((self.added(run, times) @ self.usual.sizes) ** 2, axis=0)
        return before + more

    def separations(self, run: str | None = None, times: int = 1) -> Array:
        """The part of it that no size of another explains, after a run."""
        gram = self.reduced.normal.information
        if run is not None:
            columns = self.added(run, times)
            gram = gram + columns.T @ columns
        return self.usual.separations(gram)

    def require(self, effects: Sequence[str]) -> None:
        """Raise an UnknownNameError if effects do not take part."""
        for name in effects:
            if name not in self.candidates:
                raise no_such_effect(name, sorted(self.candidates))


def ground_of(
    model: Asked,
    campaign: Campaign | None = None,
    *,
    limits: Limits | None = None,
    options: Sequence[Option] | None = None,
    floor: float = FLOOR,
    noise: float | None = None,
    record_noise: float = 0.015,
    candidates: Sequence[Candidate] | None = None,
    given: Sequence[str] = (),
) -> Ground:
    """Measured and possible runs on one footing."""
    source, structure, begun = derivatives_of(model)
    own = written_in(source if isinstance(source, Model) else None)
    if campaign is not None and campaign.runs:
        return _with_tests(
            Structure.meant_by(structure),
            campaign,
            limits or Limits.of(campaign),
            options,
            floor=floor,
            candidates=candidates,
            begun=begun,
            given=given,
            noise=noise,
            own=own,
        )
    if limits is None and options:
        limits = Limits(speeds=tuple(sorted({option.settings.speed for option in options})))
    if limits is None:
        raise DataError("Before any test a plan needs limits: the speeds at least.")
    if not isinstance(source, Model):
        raise DataError(
            "Before any test a plan needs the size of the forces: give a model with values, such "
            "as estimated_model makes from particulars, in place of a structure."
        )
    if campaign is not None:
        source = source.with_(ship=campaign.ship, water=campaign.water)
    have = tuple(dict.fromkeys((*begun, *given)))
    return _before_tests(
        source,
        limits,
        options,
        floor=floor,
        noise=record_noise,
        candidates=candidates,
        given=have,
        own=own,
    )


def _with_tests(
    structure: Structure,
    campaign: Campaign,
    limits: Limits,
    options: Sequence[Option] | None,
    *,
    floor: float,
    candidates: Sequence[Candidate] | None,
    begun: Sequence[str],
    given: Sequence[str],
    noise: float | None,
    own: Sequence[Effect],
) -> Ground:
    asked = captive_system(
        campaign, structure, floor=floor, candidates=candidates, noise=noise, own=own
    )
    system, rest = standing(asked, given, own)
    have = system.taking_part(tuple(dict.fromkeys((*begun, *rest))))
    views = system.views
    offered = _offered(options, limits, system.base)
    speeds = [*(view.speed for view in views), *limits.speeds]
    every = _candidates_of(system.base, speeds, candidates, own)
    channels = tuple(c.name for c in system.channels)
    base = _ruddered(system.base, structure, offered, channels)
    planned = _views(offered, base, measured_noise(views), campaign.motion_reference_x)
    rows = rows_of(
        [*views, *planned],
        base,
        every,
        floor=floor,
        scatter=system.scatter,
        scale={c.name: c.scale for c in system.channels},
    )
    values = {name: [b.value for b in best_blocks(system, name, 2)] for name in have}
    made = tuple(dict.fromkeys(view.run.id for view in views))
    every = tuple(item for item in every if item.name not in given)
    return _ground(rows.condition_on(values), made, offered, every, have, system)


def _before_tests(
    model: Model,
    limits: Limits,
    options: Sequence[Option] | None,
    *,
    floor: float,
    noise: float,
    candidates: Sequence[Candidate] | None,
    given: tuple[str, ...],
    own: Sequence[Effect],
) -> Ground:
    base = base_of(model, limits.speeds)
    offered = _offered(options, limits, base)
    structure = Structure.meant_by([name for own in base.names.values() for name in own])
    base = _ruddered(base, structure, offered, CHANNELS)
    rough = _views(offered, base, stated_noise(dict.fromkeys(CHANNELS, 1.0)), 0.0)
    scale = {c.name: c.scale for c in channels_of(rough, base)}
    size = {name: x * base.reference**2 for name, x in scale.items()}
    silent = [name for name, x in size.items() if not x > 0]
    if silent:
        raise DataError(
            f"The model has no {' and no '.join(silent)} in any of these runs, so that nothing "
            "says how large the noise will be.",
            remedy="Offer a run with drift, sway or yaw as well.",
        )
    planned = _views(offered, base, stated_noise(size, noise), 0.0)
    every = _candidates_of(base, limits.speeds, candidates, own)
    usual = RunEffects.most_probable(dict.fromkeys(scale, ()))
    rows = rows_of(planned, base, every, floor=floor, scatter=usual, scale=scale)
    grids = {c.name: c.grid for c in every}
    values = {name: grids[name][len(grids[name]) // 2 :][:1] for name in given if name in grids}
    return _ground(rows.condition_on(values), (), offered, every, given, None)


def _ground(
    rows: WhitenedRows,
    made: tuple[str, ...],
    offered: Sequence[Option],
    every: Sequence[Candidate],
    given: tuple[str, ...],
    system: System | None,
) -> Ground:
    return Ground(
        rows=rows,
        made=made,
        given=given,
        system=system,
        options=MappingProxyType({option.run().id: option for option in offered}),
        candidates=MappingProxyType({c.name: c for c in every if c.name not in given}),
    )


def _offered(
    options: Sequence[Option] | None, limits: Limits, base: CaptiveBase
) -> tuple[Option, ...]:
    found = options_of(limits, base.ship, base.water) if options is None else tuple(options)
    if not found:
        raise DataError("No run is possible within these limits.")
    return tuple({option.id: option for option in found}.values())


def _ruddered(
    base: CaptiveBase, structure: Structure, offered: Sequence[Option], channels: Sequence[str]
) -> CaptiveBase:
    """The base with what rudder and heel runs would add to it."""
    runs = [option.run() for option in offered]
    return with_names(base, columns_of(structure, runs, channels).required)


def _views(
    offered: Sequence[Option], base: CaptiveBase, noise: NoiseOf, motion_x: float
) -> list[View]:
    return [
        view for option in offered for view in planned_views(option, base, noise, motion_x=motion_x)
    ]


def _candidates_of(
    base: CaptiveBase,
    speeds: Sequence[float],
    candidates: Sequence[Candidate] | None,
    own: Sequence[Effect],
) -> tuple[Candidate, ...]:
    if candidates is not None:
        return tuple(candidates)
    every = eligible(base, sorted({round(speed, 6) for speed in speeds}), own)
    return tuple(drawn_once(item) for item in every)
