"""The words a user starts with, where they are more than a name of a room."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np

from pmmkit.base import MissingPartError
from pmmkit.conventions import STRUCTURES, Ship, Structure, Water, bibtex, parse_derivative
from pmmkit.effects import CATALOGUE
from pmmkit.models import (
    DerivativeTable,
    Missing,
    Model,
    Part,
    hull_less_model,
    lent,
    load_model,
    straight_polynomial,
    to_model,
    with_stated,
)
from pmmkit.reduction import Parts, Reduction, reduce_campaign
from pmmkit.validation import as_tested

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign


def reduce(
    campaign: Campaign,
    structure: str | Sequence[str] | Structure = "abkowitz3",
    fn: Literal["each", "pooled"] = "each",
    *,
    cycles: int | tuple[int, int] | None = None,
    carriage_speed: bool = False,
) -> DerivativeTable:
    """Derivatives from a campaign of captive tests.

    The short form of `reduction.reduce_campaign`, which also gives what stands behind the table.

    Parameters
    ----------
    campaign : Campaign
        Captive tests, as `open_campaign` gives them.
    structure : str, sequence of str or Structure
        Name of a structure (``abkowitz3``, ``modulus``, ``mmg`` …) or a list of derivatives;
        ``auto`` takes the largest of which the runs determine every term of side force and moment.
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
        known = STRUCTURES.get(str(thing.provenance.get("structure")))
        return bibtex(("pmmkit", *(known.sources if known else ())))
    model = thing if isinstance(thing, Model) else load_model(thing)
    values = [key for part in model.parts.values() for key in part.references]
    forms = [key for name in model.parts for key in CATALOGUE[name].sources]
    return bibtex(("pmmkit", *values, *forms))


def ship_as_tested(campaign: Campaign) -> Model:
    """The tested model with propeller and rudder as its campaign file states them.

    What ``[propeller]`` and ``[rudder]`` do not hold is estimated from the particulars, each value
    with its source and its uncertainty; an open-water table gives KT.

    Parameters
    ----------
    campaign : Campaign
        Its ship, water, propeller and rudder.

    Returns
    -------
    Model
        Without a hull: `to_model` takes it as the parts of a table.
    """
    curve = campaign.open_water
    told = dict(campaign.propeller)
    if curve is not None:
        told |= straight_polynomial(*curve)
    return hull_less_model(campaign.ship, campaign.water, told, campaign.rudder)


def carried_to(model: Model, campaign: Campaign) -> Model:
    """A model as the ship of a campaign is built: its scale, mass and water, propeller and rudder.

    Parameters
    ----------
    model : Model
        Of the same hull, at any scale.
    campaign : Campaign
        Says the length, mass, inertia and water of its ship, and of propeller and rudder what it
        states: diameter, open-water table, movable area, height, rate of the steering gear.

    Returns
    -------
    Model
        By Froude's law without correction of friction or wake; what the campaign does not state
        keeps its value. Each change is a step or a note.

    Raises
    ------
    ModelError
        If the proportions of the two hulls differ.
    """
    made, notes = as_tested(model, campaign)
    stated = dict(campaign.propeller)
    curve = campaign.open_water
    if curve is not None:
        stated |= straight_polynomial(*curve)
    whose = f"{campaign.title or campaign.ship.name}, by its campaign file"
    made = _with_stated_parts(made, stated, campaign.rudder, whose)
    areas = {key for key in campaign.rudder if key.startswith("area")}
    if {"area_lateral", "area_total"} & areas and not {"area", "area_movable"} & areas:
        notes.append("The movable area of the rudder is not stated: the model keeps its own.")
    return made.with_(notes=(*made.notes, *notes))


def model_of(
    reduction: Reduction,
    parts: str | Path | Model | None = None,
    *,
    missing: Missing = "estimate",
    force: bool = False,
) -> Model:
    """A model from a reduction: its hull, and propeller and rudder by what is known of them.

    Parameters
    ----------
    reduction : Reduction
        As `reduce_campaign` gives it.
    parts : str, path or Model, optional
        Library name or model file of the same ship that lends propeller and rudder. By default
        they are what these tests show (`Parts.of`), else what the campaign file states and
        estimates from the particulars (`ship_as_tested`).
    missing : {"estimate", "refuse", "zero", "library"}
        What stands for derivatives that the tests do not give, as for `to_model`.
    force : bool
        Make a model of derivatives that are not usable; a step marks it for ever.

    Returns
    -------
    Model
        At the scale of the parts, for the Froude numbers at which sway and yaw were tested. Each
        value says where it comes from, estimates with their uncertainty.

    Raises
    ------
    NotUsableError
        If the verdict of the reduction is that, and `force` is not set.
    MissingPartError
        If the table lacks Yv, Yr, Nv or Nr, or what `missing` does not fill.
    """
    table, left = _tested_in_full(reduction.table, Model.needed(estimated=missing == "estimate"))
    table = _without_thrust(reduction, table)
    how: dict[str, Any] = {"missing": missing, "also": _not_shown(reduction), "force": force}
    if parts is not None:
        model = to_model(table, parts, **how)
        donor = parts if isinstance(parts, Model) else load_model(parts)
        own_ship = not donor.ship.form_apart(reduction.campaign.ship)
        others = {
            name: part if part.std else lent(part, same_ship=own_ship)
            for name, part in model.parts.items()
            if name not in model.derivative_parts
        }
        return model.with_(
            parts=MappingProxyType({**model.parts, **others}), notes=(*left, *model.notes)
        )
    donor = _rolling(ship_as_tested(reduction.campaign), reduction, table)
    found = _parts_by_tests(reduction, donor)
    if found is not None:
        donor = _with_tests(donor, found)
        table = _without_rudder(reduction, table, found)
    model = to_model(table, donor, **how)
    return model.with_(
        title=f"{donor.name}, from its tests", notes=(*donor.notes, *left, *model.notes)
    )


def _without_thrust(reduction: Reduction, table: DerivativeTable) -> DerivativeTable:
    """The table without Xuu where it holds the thrust of a propeller: the model has its own."""
    inside = [reduction.solution.Fn[group] for group in reduction.thrust_inside]
    if not inside or "Xuu" not in table:
        return table
    value = table.value.copy()
    value[np.isin(table.Fn, inside) | table.pooled, table.index("Xuu")] = np.nan
    return table.with_(value=value)


def _not_shown(reduction: Reduction) -> list[str]:
    """Terms of a third-order hull that a structure lacks and the runs do not show.

    They are estimated, whatever the structure's name: to leave a coupling out would be to say that
    it is zero. Terms that the runs show and that were not asked for are left out, and told
    (`models.Standing`).
    """
    usual = STRUCTURES[_THIRD_ORDER].derivatives
    chosen = STRUCTURES.get(reduction.table.provenance["structure"])
    if chosen is None or not set(chosen.derivatives) < set(usual):
        return []
    lacking = [name for name in usual if name not in chosen.derivatives]
    if reduction.because or not _coupled(reduction):
        return lacking
    return []


def _coupled(reduction: Reduction) -> bool:
    """Whether the ship both drifts and yaws in some run."""
    sizes = np.array(
        [
            [
                np.linalg.norm(row.design["Y"][:, row.names["Y"].index(name)])
                for name in ("Yv", "Yr")
            ]
            for row in reduction.rows
            if "Y" in row.design and {"Yv", "Yr"} <= set(row.names["Y"])
        ]
    )
    return bool(len(sizes)) and bool((sizes > BOTH * sizes.max(axis=0)).all(axis=1).any())


DAMPED: Final = (0.05, 0.03)
"""Roll damping over the critical one, how far ships lie from it; S175 of the library: 0.048."""
TURNS: Final = ("area", "area_movable")
"""What a campaign file calls the area that the effect ``rudder_mmg`` has."""
_THIRD_ORDER: Final = "abkowitz3"
BOTH: Final = 0.1
"""A run drifts, or yaws, where it does so by more than this share of the run that does it most."""


def roll_from_particulars(ship: Ship, water: Water, *, damped: bool = False) -> Part | None:
    """Righting moment and damping of a ship that states GM and its inertia of roll.

    Parameters
    ----------
    ship, water : Ship, Water
        The ship or model and its water.
    damped : bool
        Whether derivatives by the roll rate were measured: then nothing is added to them.

    Returns
    -------
    Part or None
        The part ``roll``: damping a twentieth of the critical one, with its uncertainty. None
        where GM or the inertia is not known.

    Examples
    --------
    >>> from pmmkit.models import load_ship
    >>> roll = roll_from_particulars(load_ship("s175"), Water(rho=1025.0))
    >>> f"{roll.values['damping']:.3g}"
    '3.08e+07'
    """
    if ship.GM is None or ship.GM <= 0 or ship.Ixx is None:
        return None
    righting = water.rho * water.g * ship.volume * ship.GM
    share, doubt = (0.0, 0.0) if damped else DAMPED
    critical = 2.0 * math.sqrt(righting * ship.Ixx)
    return Part(
        effect="roll",
        values=MappingProxyType({"damping": share * critical}),
        source="measured: GM of the campaign file",
        sources=MappingProxyType({} if damped else {"damping": "empirical: usual roll damping"}),
        std=MappingProxyType({} if damped else {"damping": doubt * critical}),
    )


def _rolling(stated: Model, reduction: Reduction, table: DerivativeTable) -> Model:
    """The tested model with roll, where K was measured and the ship states GM and its inertia."""
    if not any("K" in item.force for item in reduction.rows):
        return stated
    damped = "Kp" in table and bool(np.isfinite(table["Kp"]).all())
    part = roll_from_particulars(stated.ship, stated.water, damped=damped)
    lacking = ""
    if not any(parse_derivative(name).channel == "K" for name in table.names):
        lacking = "the structure has no roll moment (son-nomoto has)"
    elif part is None:
        lacking = "GM and Ix of [ship] are not stated"
    if part is None or lacking:
        told = f"K was measured, but {lacking}: the model does not roll."
        return stated.with_(notes=(*stated.notes, told))
    guessed = () if damped else ("Roll damping was not measured: a twentieth of the critical one.",)
    return stated.with_(
        parts=MappingProxyType({**stated.parts, part.effect: part}), notes=(*stated.notes, *guessed)
    )


def _parts_by_tests(reduction: Reduction, stated: Model) -> Parts | None:
    """Propeller and rudder where static tests with their gauges show them."""
    blade = stated.parts["rudder_mmg"]
    try:
        return Parts.of(
            reduction,
            area=_one(blade, "area"),
            height=_one(stated.parts["propeller"], "D") / _one(blade, "eta"),
            lift_slope=_one(blade, "lift_slope"),
            lR=_one(blade, "lR"),
            rate_deg_s=_one(blade, "rate_deg_s"),
            assumed=blade.source_of("lR"),
        )
    except MissingPartError:
        return None


def _with_tests(stated: Model, found: Parts) -> Model:
    """The tested model with parts by tests; what they assume keeps its doubt."""
    parts = {}
    for part in (found.propeller, found.rudder):
        doubt = stated.parts[part.effect].std
        assumed = {name: x for name, x in doubt.items() if part.source_of(name) != part.source}
        tested = {name: x for name, x in found.std.items() if name in part.values}
        parts[part.effect] = replace(part, std=MappingProxyType({**assumed, **tested}))
    return stated.with_(parts=MappingProxyType(parts), notes=found.notes)


def _without_rudder(reduction: Reduction, table: DerivativeTable, found: Parts) -> DerivativeTable:
    """The hull without the rudder that was on it, where the propeller turned behind it."""
    turning = [
        (run.settings.speed, run.settings.propeller_rps)
        for run in reduction.campaign
        if run.settings.propeller_rps and not run.kind_of_test.straight_ahead
    ]
    if not turning:
        return table
    speed, revolutions = np.median(np.array(turning, float), axis=0).tolist()
    return found.hull_alone(table, speed=speed, revolutions=revolutions)


def _one(part: Part, name: str) -> float:
    value = part.values[name]
    return value[0] if isinstance(value, tuple) else value


def _tested_in_full(
    table: DerivativeTable, needed: Sequence[str]
) -> tuple[DerivativeTable, list[str]]:
    """The rows in which what a model needs has values, and in words the rows left out."""
    columns = [table.index(name) for name in needed if name in table]
    full = np.isfinite(table.value[:, columns]).all(axis=1)
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


def _with_stated_parts(
    model: Model, propeller: Mapping[str, Any], rudder: Mapping[str, Any], because: str
) -> Model:
    """A model whose propeller and rudder have the values that somebody states, by the names of the
    effects ``propeller`` and ``rudder_mmg``, the ``area_movable`` of the rudder [m²] and its
    ``height`` [m]; other entries do not count.

    What is not stated keeps its value. The slipstream reaches as much of the rudder as the stated
    diameter and height say, or as the diameter has changed.

    Examples
    --------
    >>> ship = load_model("kvlcc2-l7")
    >>> other = _with_stated_parts(ship, {"D": 0.22}, {}, "the new propeller")
    >>> round(other.values("rudder_mmg")["eta"] / ship.values("rudder_mmg")["eta"], 3)
    1.019
    """
    stated: dict[str, float] = {}
    if "propeller" in model.parts:
        stated |= _stated_values(model, "propeller", propeller)
    if "rudder_mmg" in model.parts:
        areas = [x for name in TURNS if (x := rudder.get(name))]
        given = {**rudder, "area": areas[0]} if areas else rudder
        stated |= _stated_values(model, "rudder_mmg", given)
        place = "rudder_mmg.eta"
        if place not in stated and (eta := _reach(model, stated, rudder)) is not None:
            stated[place] = eta
    return with_stated(model, stated, because) if stated else model


def _stated_values(model: Model, part: str, given: Mapping[str, Any]) -> dict[str, float]:
    """Those entries that are values of a part and differ from what it has."""
    own = model.parts[part]
    return {
        f"{part}.{item.name}": float(x)
        for item in own.known.parameters
        if isinstance(x := given.get(item.name), int | float)
        and not isinstance(x, bool)
        and own.values.get(item.name) != x
    }


def _reach(model: Model, stated: Mapping[str, float], rudder: Mapping[str, Any]) -> float | None:
    """Diameter of the propeller over the height of the rudder; None where nothing changes it."""
    if "propeller" not in model.parts:
        return None
    before = model.parts["propeller"].values.get("D")
    eta = model.parts["rudder_mmg"].values.get("eta")
    after = stated.get("propeller.D", before)
    if not (isinstance(before, float) and isinstance(after, float) and isinstance(eta, float)):
        return None
    height = rudder.get("height")
    new = after / float(height) if height else eta * after / before
    return None if new == eta else new
