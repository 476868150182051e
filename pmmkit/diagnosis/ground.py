"""What a plan stands on: runs made and possible runs, seen with one base and one noise."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Final

import numpy as np

from pmmkit.conventions import Convention
from pmmkit.diagnosis.base import Base
from pmmkit.diagnosis.build import build
from pmmkit.diagnosis.candidate import Candidate
from pmmkit.diagnosis.faults import FAULTS, carriage_fault
from pmmkit.diagnosis.information import FADING, Known, Rows, known, rows_of
from pmmkit.diagnosis.options import Limits, Option, limits_of, options_of
from pmmkit.diagnosis.physics import PHYSICS
from pmmkit.diagnosis.planned import (
    NoiseOf,
    base_of,
    measured_noise,
    planned_views,
    stated_noise,
    with_names,
)
from pmmkit.diagnosis.system import Scatter, channels_of
from pmmkit.diagnosis.views import View, views_of
from pmmkit.effects.catalogue import catalogue
from pmmkit.errors import DataError
from pmmkit.model import Model, load_model
from pmmkit.reduction.columns import columns_of
from pmmkit.runs.run import Campaign
from pmmkit.structures import STRUCTURES, Structure, structure_of

Asked = Model | str | Path | Sequence[str] | Structure
CHANNELS: Final = ("X", "Y", "N")


@dataclass(frozen=True, kw_only=True, eq=False)
class Ground:
    """Runs made and runs that could be made.

    Parameters
    ----------
    rows : Rows
        Of all of them.
    made : tuple of str
        Ids of the runs that are made.
    options : mapping of str to Option
        Runs that could be made, by their id among the rows.
    candidates : mapping of str to Candidate
        Effects and faults by name.
    """

    rows: Rows
    made: tuple[str, ...]
    options: Mapping[str, Option]
    candidates: Mapping[str, Candidate]

    def known(self) -> Known:
        """What the runs made tell."""
        return known(self.rows, self.made)


def ground_of(
    model: Asked, campaign: Campaign | None = None, *, limits: Limits | None = None,
    options: Sequence[Option] | None = None, floor: float = 0.005, noise: float = 0.015,
    candidates: Sequence[Candidate] | None = None,
) -> Ground:  # fmt: skip
    """Measured and possible runs on one footing.

    Parameters
    ----------
    model : Model, str, path, sequence of str or Structure
        The base, as for `diagnose`; a model where there are no tests.
    campaign : Campaign, optional
        Tests that are made.
    limits : Limits, optional
        What tank and rig allow; what the campaign has done by default.
    options : sequence of Option, optional
        Runs that could be made; within the limits by default.
    floor : float
        What is too small to matter, over the rms force of a channel.
    noise : float
        Standard deviation of a record's noise over the rms force, where no test tells it.
    candidates : sequence of Candidate, optional
        Effects and faults; the catalogue by default.

    Returns
    -------
    Ground

    Raises
    ------
    DataError
        If there are neither tests nor a model with values, or nothing can be offered.
    """
    views = [] if campaign is None else [view for view in views_of(campaign) if view.force]
    loaded = _loaded(model)
    if campaign is not None and campaign.runs:
        limits = limits or limits_of(campaign)
    if limits is None and options is not None:
        limits = Limits(speeds=tuple(sorted({option.settings.speed for option in options})))
    if limits is None:
        raise DataError("Before any test a plan needs limits: the speeds at least.")
    if views and campaign is not None:
        return _with_tests(
            loaded, campaign, views, limits, options, floor=floor, candidates=candidates
        )
    if campaign is not None and campaign.runs:
        raise DataError(
            "No run states its noise: a plan on top of tests needs histories. Leave the tests out "
            "(open_campaign(…, runs=False), --before) to plan as if none were made."
        )
    if not isinstance(loaded, Model):
        raise DataError(
            "Before any test a plan needs the size of the forces: give a model with values, such "
            "as estimated_model makes from particulars, in place of a structure."
        )
    if campaign is not None:
        loaded = loaded.with_(ship=campaign.ship, water=campaign.water)
    return _before_tests(
        loaded, limits, options, floor=floor, noise=noise, candidates=candidates
    )  # fmt: skip


def _loaded(model: Asked) -> Model | Structure:
    if isinstance(model, (Structure, Model)):
        return model
    if isinstance(model, Path) or (isinstance(model, str) and model not in STRUCTURES):
        return load_model(model)
    return structure_of(model)


def derivatives_of(model: Model) -> tuple[str, ...]:
    """Derivatives of hull and added mass that a model has."""
    return tuple(
        name
        for effect in ("hull_polynomial", "added_mass")
        if effect in model.parts
        for name in model.parts[effect].values
        if catalogue()[effect].parameter(name) is None
    )


def _with_tests(
    model: Model | Structure, campaign: Campaign, views: Sequence[View], limits: Limits,
    options: Sequence[Option] | None, *, floor: float, candidates: Sequence[Candidate] | None,
) -> Ground:  # fmt: skip
    structure = structure_of(derivatives_of(model)) if isinstance(model, Model) else model
    channels = tuple(dict.fromkeys(name for view in views for name in view.force))
    speeds = sorted({round(view.speed, 6) for view in views})
    base = Base(
        names=columns_of(structure, campaign.runs, channels).required, values={},
        ship=campaign.ship, water=campaign.water, convention=Convention(),
        reference=float(np.median(speeds)),
    )  # fmt: skip
    offered = _offered(options, limits, base)
    every = _contestants(base, [*speeds, *limits.speeds], candidates)
    system = build(views, base, [c for c in every if c is not FADING], floor=floor)
    wider = _ruddered(system.base, structure, offered, channels)
    noise = measured_noise(views)
    planned = _views(offered, wider, noise, campaign.motion_reference_x)
    rows = rows_of(
        [*views, *planned], wider, every, floor=floor, scatter=system.scatter,
        scale={c.name: c.scale for c in system.channels},
    )  # fmt: skip
    return _ground(rows, tuple(dict.fromkeys(view.run.id for view in views)), offered, every)


def _before_tests(
    model: Model, limits: Limits, options: Sequence[Option] | None, *, floor: float, noise: float,
    candidates: Sequence[Candidate] | None,
) -> Ground:  # fmt: skip
    base = base_of(model, limits.speeds)
    offered = _offered(options, limits, base)
    structure = structure_of([name for own in base.names.values() for name in own])
    base = _ruddered(base, structure, offered, CHANNELS)
    rough = _views(offered, base, stated_noise(dict.fromkeys(CHANNELS, 1.0)), 0.0)
    scale = {c.name: c.scale for c in channels_of(rough, base)}
    size = {name: x * base.reference**2 for name, x in scale.items()}
    planned = _views(offered, base, stated_noise(size, noise), 0.0)
    every = _contestants(base, limits.speeds, candidates)
    rows = rows_of(planned, base, every, floor=floor, scatter=Scatter(), scale=scale)
    return _ground(rows, (), offered, every)


def _ground(
    rows: Rows, made: tuple[str, ...], offered: Sequence[Option], every: Sequence[Candidate]
) -> Ground:
    return Ground(
        rows=rows, made=made,
        options=MappingProxyType({option.run().id: option for option in offered}),
        candidates=MappingProxyType({c.name: c for c in every}),
    )  # fmt: skip


def _offered(options: Sequence[Option] | None, limits: Limits, base: Base) -> tuple[Option, ...]:
    found = options_of(limits, base.ship, base.water) if options is None else tuple(options)
    if not found:
        raise DataError("No run is possible within these limits.")
    return tuple({option.id: option for option in found}.values())


def _ruddered(
    base: Base, structure: Structure, offered: Sequence[Option], channels: Sequence[str]
) -> Base:
    """The base with what rudder and heel runs would add to it."""
    runs = [option.run() for option in offered]
    return with_names(base, columns_of(structure, runs, channels).required)


def _views(
    offered: Sequence[Option], base: Base, noise: NoiseOf, motion_x: float
) -> list[View]:  # fmt: skip
    return [
        view for option in offered for view in planned_views(option, base, noise, motion_x=motion_x)
    ]


def _contestants(
    base: Base, speeds: Sequence[float], candidates: Sequence[Candidate] | None
) -> tuple[Candidate, ...]:
    """Effects and faults, without what the base has already."""
    if candidates is not None:
        return tuple(candidates)
    have = {name for names in base.names.values() for name in names}
    found = [c for c in (*PHYSICS, *FAULTS) if not set(c.coefficients) <= have]
    several = sorted({round(speed, 6) for speed in speeds})
    if len(several) > 1:
        found.append(carriage_fault(tuple(several)))
    return (*found, FADING)
