"""The words a user starts with, where they are more than a name of a room."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from pmmkit.bibliography import ITSELF, bibtex
from pmmkit.effects.catalogue import effect_of
from pmmkit.models import Model, Part, load_model, to_model
from pmmkit.models.build import NEEDED
from pmmkit.reduction import Reduction, reduce_campaign
from pmmkit.structures import Structure, structures
from pmmkit.tables import DerivativeTable

if TYPE_CHECKING:
    from pmmkit.campaigns.run import Campaign
    from pmmkit.observations.prepare import CycleChoice


def reduce(
    campaign: Campaign,
    structure: str | Sequence[str] | Structure = "abkowitz3",
    fn: Literal["each", "pooled"] = "each",
    *,
    cycles: CycleChoice = None,
    carriage_speed: bool = False,
) -> DerivativeTable:
    """Derivatives from a campaign of captive tests.

    The short form of `reduction.reduce_campaign`, which also gives what stands behind the table.

    Parameters
    ----------
    campaign : Campaign
        Captive tests, as `open_campaign` gives them.
    structure : str, sequence of str or Structure
        Name of a structure (``abkowitz3``, ``modulus``, ``mmg`` …) or a list of derivatives.
    fn : {"each", "pooled"}
        A set of derivatives per Froude number, or one over all speeds.
    cycles : int or (int, int), optional
        Take only this cycle, or these (the first is 1), of oscillating runs; by default a
        cycle-to-cycle test decides.
    carriage_speed : bool
        Make non-dimensional with the carriage speed instead of the instantaneous one.

    Returns
    -------
    DerivativeTable
        With covariance, 95 % intervals by `interval`, and notes on what the runs do not tell.

    Raises
    ------
    ContradictionError
        If the data contradict themselves or the campaign file.
    CampaignError
        If runs cannot be read.
    """
    return reduce_campaign(
        campaign, structure=structure, fn=fn, cycles=cycles, carriage_speed=carriage_speed
    ).table


def citation(thing: Model | DerivativeTable | str | Path) -> str:
    """What to cite for a model or a derivative table, as BibTeX.

    Parameters
    ----------
    thing : Model or DerivativeTable or str or path
        A model, the name of a library ship or the path of a model file: pmmkit, the sources of the
        values and those of its effects. A table: pmmkit and the sources of its structure.

    Returns
    -------
    str
        Entries in BibTeX, each once.

    Raises
    ------
    UnknownNameError
        If a model file quotes a source that is not in the bibliography.

    Examples
    --------
    >>> [line for line in citation("kvlcc2").splitlines() if line.startswith("@")][:2]
    ['@misc{pmmkit,', '@article{yasukawa_yoshimura_2015,']
    """
    if isinstance(thing, DerivativeTable):
        known = structures().get(str(thing.provenance.get("structure")))
        return bibtex((ITSELF, *(known.sources if known else ())))
    model = thing if isinstance(thing, Model) else load_model(thing)
    values = [key for part in model.parts.values() for key in part.references]
    forms = [key for name in model.parts for key in effect_of(name).sources]
    return bibtex((ITSELF, *values, *forms))


def ship_as_tested(campaign: Campaign) -> Model:
    """The tested model with the propeller and the rudder that its campaign file describes.

    A part enters if the sections ``[propeller]`` and ``[rudder]`` hold every number that the
    effect of the catalogue needs; what is absent is said in the notes.

    Parameters
    ----------
    campaign : Campaign
        Its ship, water, propeller and rudder.

    Returns
    -------
    Model
        Without a hull: `to_model` takes it as the parts of a table.
    """
    parts, notes = {}, []
    for effect, section, given in (
        ("propeller", "propeller", campaign.propeller),
        ("rudder_mmg", "rudder", campaign.rudder),
    ):
        part, lacking = _part(effect, given)
        if part is not None:
            parts[effect] = part
        else:
            notes.append(
                f"No {section}: [{section}] of the campaign file lacks {', '.join(lacking)}."
                if given
                else f"No {section}: the campaign file has no [{section}]."
            )
    return Model(
        name=campaign.ship.name,
        ship=campaign.ship,
        water=campaign.water,
        parts=MappingProxyType(parts),
        notes=tuple(notes),
        scale=f"L = {campaign.ship.L:.4g} m, the scale of the tests",
    )


def _part(effect: str, given: Mapping[str, Any]) -> tuple[Part | None, list[str]]:
    """A part from free particulars, or the names of the parameters that are not there."""
    known = effect_of(effect)
    options = {
        name: str(given[name]) if name in given else words[0]
        for name, words in known.options.items()
    }
    values = {
        parameter.name: float(given[parameter.name])
        for parameter in known.parameters
        if isinstance(given.get(parameter.name), (int, float))
    }
    lacking = [
        parameter.name
        for parameter in known.parameters
        if parameter.name not in values
        and parameter.default is None
        and (parameter.form is None or options[parameter.form[0]] in parameter.form[1:])
    ]
    if lacking:
        return None, lacking
    return (
        Part(
            effect=effect,
            values=MappingProxyType(values),
            options=MappingProxyType(options),
            source="measured: the campaign file",
        ),
        [],
    )


def model_of(reduction: Reduction, parts: str | Path | Model | None = None) -> Model:
    """A model from a reduction: its hull, and parts of a library ship or of the campaign file.

    Parameters
    ----------
    reduction : Reduction
        As `reduce_campaign` gives it.
    parts : str, path or Model, optional
        As for `to_model`; by default what the campaign file says of the tested model
        (`ship_as_tested`), and the hull alone where it says nothing.

    Returns
    -------
    Model
        At the scale of the parts, for the Froude numbers at which sway and yaw were tested.

    Raises
    ------
    MissingPartError
        If the table lacks a derivative that every simulation needs.
    """
    donor = ship_as_tested(reduction.campaign) if parts is None else parts
    table, left = _tested_in_full(reduction.table)
    model = to_model(table, donor)
    if parts is None and isinstance(donor, Model):
        model = model.with_(title=f"{donor.name}, from its tests")
        left = [*donor.notes, *left]
    return model.with_(notes=(*left, *model.notes))


def _tested_in_full(table: DerivativeTable) -> tuple[DerivativeTable, list[str]]:
    """The rows in which what a model needs has values, and in words the rows left out."""
    needed = [table.index(name) for name in NEEDED if name in table]
    full = np.isfinite(table.value[:, needed]).all(axis=1)
    if table.pooled or full.all() or not full.any():
        return table, []
    left = ", ".join(f"{froude:.3f}" for froude in table.Fn[~full])
    chosen = table.with_(
        Fn=table.Fn[full],
        value=table.value[full],
        covariance=table.covariance[full][:, :, full],
        dof=table.dof[full],
        method=table.method[full],
        runs=table.runs[full],
    )
    return chosen, [f"Sway and yaw were not tested at Fn {left}: the model leaves them out."]
