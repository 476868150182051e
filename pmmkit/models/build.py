"""From a derivative table to a model: hull from the tests, the rest from a library ship."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Final, Literal, get_args

import numpy as np

from pmmkit.base import (
    MissingPartError,
    ModelError,
    NotUsableError,
    Problem,
    Remedy,
    TableError,
    Way,
)
from pmmkit.conventions import parse_derivative
from pmmkit.effects import HULL, INERTIA, AddedMass
from pmmkit.models.estimates import estimated_table
from pmmkit.models.model import HULL_TERMS, NEEDED, Model
from pmmkit.models.part import Part, needs_roll
from pmmkit.models.step import Step, Value
from pmmkit.models.store import load_model
from pmmkit.models.tables.table import DerivativeTable

Missing = Literal["refuse", "zero", "library", "estimate"]
ESTIMATED: Final = "empirical: particulars, Yoshimura and Masumoto 2012; Clarke 1983; Zhou 1983"
EXPECTED: Final = ("Xvv", "Xrr", "Xvr", "Xudot", "Yrdot", "Nvdot")
"""Without these a simulation is wrong unless they are known to be small."""
SIMILAR: Final = 0.02
"""Share by which L/B, L/d and the block may differ before it is noted."""
DIFFERENT: Final = 0.10
"""Share by which they may differ before it is refused."""


def to_model(
    table: DerivativeTable,
    parts: str | Path | Model = "s175",
    *,
    missing: Missing = "refuse",
    name: str | None = None,
    also: Iterable[str] = (),
    force: bool = False,
) -> Model:
    """A model with the derivatives of a table on a library ship.

    Parameters
    ----------
    table : DerivativeTable
        Derivatives of the hull and its added mass, over Froude numbers or pooled. Derivatives of
        the rudder and offsets are left out: the rudder is the library's.
    parts : str, path or Model
        Library name or model file: particulars, mass and inertia, propeller, rudder, roll, and
        so the scale of the model.
    missing : {"refuse", "zero", "library", "estimate"}
        What to do where the table has no value (absent or NaN): refuse; take zero; take the
        acceleration derivatives of `parts` (of those alone; the rest is refused); or take the
        value of other Froude numbers, else an estimate from the particulars with its uncertainty,
        else zero. Yv, Yr, Nv and Nr are refused always, Xuu, Yvdot and Nrdot never taken as zero.
    name : str, optional
        Name of the model; by default that of the table's ship.
    also : iterable of str
        Derivatives that the model shall have though the table does not name them.
    force : bool
        Make a model of a table that its reduction found not usable. A step of the model says so
        for ever, and whatever sails it does too.

    Returns
    -------
    Model
        At the scale of `parts`, by Froude's law without correction of friction or wake; 4 degrees
        of freedom if the table has derivatives of roll, else 3.

    Raises
    ------
    NotUsableError
        If the reduction of the table found it not usable, and `force` is not set.
    MissingPartError
        If a derivative is missing: which, and the tests that would give it.
    ModelError
        If the table's ship is another one than that of `parts`, or its derivatives refer to
        another point than midship.
    TableError
        If `missing` is none of these words.

    Examples
    --------
    >>> from pmmkit.models.tables.table import from_values
    >>> library = load_model("s175-3dof")
    >>> values = {name: value for part in ("hull_polynomial", "added_mass")
    ...           for name, value in library.parts[part].values.items()}
    >>> table = from_values(values, ship=library.ship, water=library.water,
    ...                     convention=library.convention)
    >>> to_model(table, "s175").values("hull_polynomial")["Nvvr"]
    -0.0424
    """
    if missing not in get_args(Missing):
        raise TableError(f"missing = {missing!r} is not known: {', '.join(get_args(Missing))}.")
    forced = _usable(table, force=force)
    donor = parts if isinstance(parts, Model) else load_model(parts)
    _check_similar(table, donor)
    if missing == "estimate":
        table = _held(table)
    taken, left, notes = _choose(table, donor)
    borrowed, guessed, zeroed = _fill(table, donor, taken, left, missing, also)
    taken = [item for item in taken if item not in left]
    rows = () if table.pooled else tuple(float(x) for x in table.Fn)
    values: dict[str, Value] = {item: _value(table, item) for item in taken}
    values |= dict.fromkeys(zeroed, 0.0)
    values |= {item: value for item, (value, _) in guessed.items()}
    hull = {item: value for item, value in values.items() if not _accelerates(item)}
    mass = {item: value for item, value in values.items() if _accelerates(item)} | borrowed
    origin = f"measured: {table.ship.name}"
    assumed = dict.fromkeys(zeroed, "assumed: zero")
    lent = dict.fromkeys(borrowed, f"library: {donor.name}")
    lent |= dict.fromkeys(guessed, ESTIMATED)
    doubt = {item: std for item, (_, std) in guessed.items()}
    own = {
        HULL: Part(
            effect=HULL,
            values=MappingProxyType(hull),
            source=origin,
            sources=MappingProxyType({k: v for k, v in (assumed | lent).items() if k in hull}),
            std=MappingProxyType({k: x for k, x in doubt.items() if k in hull}),
        ),
        INERTIA: Part(
            effect=INERTIA,
            values=MappingProxyType(mass),
            source=origin,
            references=donor.parts[INERTIA].references if borrowed else (),
            sources=MappingProxyType({k: v for k, v in (assumed | lent).items() if k in mass}),
            std=MappingProxyType({k: x for k, x in doubt.items() if k in mass}),
        ),
    }
    rolls = donor.rolls and any(needs_roll(item) for item in taken)
    depth = _depth(table, donor)
    here = () if depth is None else donor.in_role("depth")
    others = {
        key: donor.parts[key]
        for key in donor.parts
        if key not in own
        and key not in here
        and key != "rudder_abkowitz"
        and (rolls or key != "roll")
    }
    notes += [
        f"Left out of the model: {key}, because the tests were made over their bottom."
        for key in here
    ]
    names = tuple(item for item in taken)
    if zeroed:
        notes.append(f"Taken as zero because the table has no value: {', '.join(zeroed)}.")
    if guessed:
        notes.append(f"Estimated from the ship's particulars: {', '.join(guessed)}.")
    if borrowed:
        notes.append(f"Taken from {donor.name}: {', '.join(borrowed)}.")
    return Model(
        name=name or table.ship.name,
        ship=replace(donor.ship, name=name or donor.ship.name),
        water=donor.water if depth is None else replace(donor.water, depth=depth),
        parts=MappingProxyType({**own, **others}),
        convention=table.convention,
        Fn=rows,
        covariance=_covariance(table, names),
        covariance_names=names if _covariance(table, names) is not None else (),
        title=f"Hull of {table.ship.name}; other parts of {donor.name}",
        scale=_scale(table, donor),
        notes=(*notes, *table.notes),
        steps=(
            Step(
                action="built",
                ship=table.ship.name,
                parts=donor.name,
                misfit=tuple(table.provenance.get("misfit", ())),
            ),
            *forced,
        ),
    )


def _usable(table: DerivativeTable, *, force: bool) -> tuple[Step, ...]:
    """The step that marks a model of a table that is not usable; none where it is usable."""
    faults = table.verdict.faults if table.verdict else ()
    if faults and not force:
        raise NotUsableError(
            [*(Problem(message=text) for text in faults), _BY_FORCE],
            title=f"The derivatives of {table.ship.name} are not usable",
        )
    return (Step(action="forced", ship=table.ship.name, names=faults),) if faults else ()


_BY_FORCE: Final = Problem(
    message="No model was made.",
    remedy=Remedy(
        "Mend the tests, or make one by force, which stays marked ({}).",
        (Way.setting("force", True),),
    ),
)


def _depth(table: DerivativeTable, donor: Model) -> float | None:
    """Depth of the water [m] at the scale of the model; None where the table states none."""
    return None if table.water.depth is None else table.water.depth * donor.ship.d / table.ship.d


def _accelerates(name: str) -> bool:
    return name == "lx" or any(factor.endswith("dot") for factor in parse_derivative(name).factors)


def _check_similar(table: DerivativeTable, donor: Model) -> None:
    if table.convention.moment_reference_x or table.convention.motion_reference_x:
        raise ModelError(
            f"The table refers to x = {table.convention.moment_reference_x:g} m (moments) and "
            f"{table.convention.motion_reference_x:g} m (motions); convert it to midship first."
        )
    wrong = [
        f"{label} is {ours:.4g} in the table and {theirs:.4g} in {donor.name}."
        for label, ours, theirs in _ratios(table, donor)
        if abs(ours / theirs - 1) > DIFFERENT
    ]
    if wrong:
        raise ModelError(
            [Problem(message=text, remedy="Choose the parts of the same ship.") for text in wrong],
            title=f"The table is of another hull than {donor.name}",
        )


def _ratios(table: DerivativeTable, donor: Model) -> list[tuple[str, float, float]]:
    ours, theirs = table.ship, donor.ship
    return [
        ("L/B", ours.L / ours.B, theirs.L / theirs.B),
        ("L/d", ours.L / ours.d, theirs.L / theirs.d),
        ("The block coefficient", ours.block, theirs.block),
    ]


def _choose(table: DerivativeTable, donor: Model) -> tuple[list[str], list[str], list[str]]:
    """Derivatives that enter the model, those of them without a value, and notes."""
    notes = [
        f"{label} is {ours:.4g} in the tests and {theirs:.4g} in {donor.name}."
        for label, ours, theirs in _ratios(table, donor)
        if abs(ours / theirs - 1) > SIMILAR
    ]
    facts = {name: parse_derivative(name) for name in table.names}
    rudder = [name for name, it in facts.items() if it.count("d") or it.count("T")]
    offsets = [
        name
        for name, it in facts.items()
        if it.factors == ("0",) and table.convention.surge != "delta-u"
    ]
    rolls = donor.rolls and any(it.channel == "K" for it in facts.values())
    roll = [] if rolls else [name for name in table.names if needs_roll(name)]
    for names, why in (
        (rudder, f"the rudder and propeller are those of {donor.name}"),
        (offsets, "offsets belong to the tests"),
        (roll, "the model does not roll"),
    ):
        if names:
            notes.append(f"Left out of the model, because {why}: {', '.join(names)}.")
    if donor.rolls and not rolls:
        notes.append("Three degrees of freedom: the table has no derivatives of the roll moment.")
    dropped = {*rudder, *offsets, *roll}
    taken = [name for name in table.names if name not in dropped]
    empty = [name for name in taken if not np.all(np.isfinite(table[name]))]
    return taken, empty, notes


def _fill(
    table: DerivativeTable,
    donor: Model,
    taken: list[str],
    empty: list[str],
    missing: Missing,
    also: Iterable[str],
) -> tuple[dict[str, Value], dict[str, tuple[Value, float]], list[str]]:
    """Values borrowed from the library, estimates with their errors, and names taken as zero."""
    essential = [item for item in NEEDED if item != "Xuu" or table.convention.surge != "delta-u"]
    wanted = dict.fromkeys((*essential, *EXPECTED, *also))
    absent = [item for item in wanted if item not in taken]
    if table.convention.surge == "delta-u":
        absent = [item for item in absent if item in essential]
    borrowed: dict[str, Value] = {}
    guessed: dict[str, tuple[Value, float]] = {}
    zeroed, refused = [], []
    guess = estimated_table(table) if missing == "estimate" and (absent or empty) else None
    for item in (*absent, *empty):
        if missing == "library" and _accelerates(item):
            value = _borrow(item, table, donor)
            if value is not None:
                borrowed[item] = value
                continue
        if guess is not None and item not in HULL_TERMS and item in guess:
            guessed[item] = _value(guess, item), float(np.mean(guess.std[:, guess.index(item)]))
            continue
        if missing in ("zero", "estimate") and item not in NEEDED:
            zeroed.append(item)
            continue
        refused.append(item)
    if refused:
        found = [
            Problem(message=_lack(item, table), remedy=f"It comes from: {tests_for(item)}.")
            for item in refused
        ]
        raise MissingPartError([*found, _way_out(refused, table)], title=_NOT_ENOUGH)
    return borrowed, guessed, zeroed


def _held(table: DerivativeTable) -> DerivativeTable:
    """Values where some Froude numbers have none: between those that have, and held beyond."""
    value = table.value.copy()
    for column in value.T:
        there = np.isfinite(column)
        if there.any() and not there.all():
            column[~there] = np.interp(table.Fn[~there], table.Fn[there], column[there])
    return table.with_(value=value)


def _lack(name: str, table: DerivativeTable) -> str:
    if name not in table:
        return f"{name} is not in the table."
    empty = ~np.isfinite(table[name])
    if table.pooled or np.all(empty):
        return f"{name} has no value: the runs do not determine it."
    at = ", ".join(f"{Fn:.3g}" for Fn in table.Fn[empty])
    return f"{name} has no value at Fn {at}."


def _way_out(refused: list[str], table: DerivativeTable) -> Problem:
    ways = []
    asked = []
    partly = [item for item in refused if item in table and np.any(np.isfinite(table[item]))]
    if partly:
        ways.append("reduce all speeds to one set ({})")
        asked.append(Way.setting("fn", "pooled"))
    if not set(refused) <= set(NEEDED):
        ways.append("take what is not essential as zero ({})")
        asked.append(Way.setting("missing", "zero"))
    if any(map(_accelerates, refused)):
        ways.append("take acceleration derivatives from the library ship ({})")
        asked.append(Way.setting("missing", "library"))
    ways.append("choose a structure without the terms that the runs do not determine")
    return Problem(
        message="What can be done without new tests:",
        remedy=Remedy(f"{'; '.join(ways)}.", tuple(asked)),
    )


def _borrow(name: str, table: DerivativeTable, donor: Model) -> float | None:
    value = donor.parts[INERTIA].values.get(name) if INERTIA in donor.parts else None
    if not isinstance(value, float):
        return None
    theirs = AddedMass.unit(name, ship=donor.ship, water=donor.water, convention=donor.convention)
    ours = AddedMass.unit(name, ship=donor.ship, water=donor.water, convention=table.convention)
    return value * theirs / ours


def tests_for(name: str) -> str:
    """The captive tests that give a derivative, in words.

    Examples
    --------
    >>> tests_for("Xvr")
    'yaw with drift, or circular motion with drift'
    """
    derivative = parse_derivative(name)
    variables = {factor.strip("|") for factor in derivative.factors}
    for needed, tests in _TESTS:
        if needed <= variables:
            return tests
    return "resistance or static drift tests"


_NOT_ENOUGH: Final = "The table does not carry a simulation"
_TESTS: Final[tuple[tuple[frozenset[str], str], ...]] = (
    (frozenset({"d"}), "static rudder tests"),
    (frozenset({"udot"}), "pure surge, or pure yaw with large heading (second harmonic of X)"),
    (frozenset({"vdot"}), "pure sway"),
    (frozenset({"rdot"}), "pure yaw"),
    (frozenset({"pdot"}), "forced roll"),
    (frozenset({"p"}), "forced roll"),
    (frozenset({"r", "phi"}), "circular motion or pure yaw with heel"),
    (frozenset({"phi"}), "static heel, with drift where v is a factor"),
    (frozenset({"v", "r"}), "yaw with drift, or circular motion with drift"),
    (frozenset({"r"}), "pure yaw or circular motion"),
    (frozenset({"v"}), "static drift or pure sway"),
)


def _value(table: DerivativeTable, name: str) -> Value:
    column = table[name]
    return float(column[0]) if table.pooled else tuple(float(x) for x in column)


def _covariance(table: DerivativeTable, names: tuple[str, ...]) -> np.ndarray | None:
    """Covariance of the normal law whose intervals are those of the table."""
    columns = [table.index(name) for name in names]
    block = table.covariance[:, columns][:, :, :, columns]
    size = len(table.Fn) * len(names)
    flat = block.reshape(size, size)
    if not np.any(np.isfinite(np.diagonal(flat))):
        return None
    wide = table.widening[:, columns].ravel()
    flat = flat * np.outer(wide, wide)
    return (flat + flat.T) / 2


def _scale(table: DerivativeTable, donor: Model) -> str:
    point = "propulsion point: self-propulsion of the model's equations"
    factor = donor.ship.L / table.ship.L
    if abs(factor - 1) < 1e-3:
        return f"L = {donor.ship.L:g} m, the scale of the tests; {point}"
    step = f"1:{factor:.4g} model tests (L = {table.ship.L:.4g} m)"
    if factor < 1:
        step = f"tests at L = {table.ship.L:.4g} m"
    return (
        f"L = {donor.ship.L:g} m: {step} carried over by Froude's law without correction of "
        f"friction or wake; {point}"
    )
