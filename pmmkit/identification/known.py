"""What is identified, and what was known of it before: from a model, another one, or a table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pmmkit.base import DataError, UnknownNameError, did_you_mean
from pmmkit.conventions import parse_derivative
from pmmkit.effects import CURRENT, HULL
from pmmkit.identification.binding import places
from pmmkit.identification.prior import Prior
from pmmkit.models import DerivativeTable, Model, ReferenceTable, converted, interpolate


def parameters_of(model: Model, asked: Sequence[str] | None) -> tuple[str, ...]:
    """What is identified: what was asked for, or all derivatives of the hull.

    Examples
    --------
    >>> from pmmkit.models import load_model
    >>> parameters_of(load_model("kvlcc2-l7"), ["Yrvv", "rudder_mmg.aH"])
    ('Yvvr', 'rudder_mmg.aH')
    """
    if asked is None:
        return tuple(model.part(HULL, "identification").values)
    if not asked:
        raise DataError("Name at least one parameter, such as --derivatives 'Yv Yr Nv Nr'.")
    there = _fittable(model)
    found = [_spelt(name) for name in asked]
    lost = [name for name in found if name not in there]
    if lost:
        raise UnknownNameError(
            f"Model {model.name!r} has no {', '.join(lost)} to identify"
            f"{did_you_mean(lost[0], there) or '.'} It has {', '.join(there)}."
        )
    return tuple(dict.fromkeys(found))


def _spelt(name: str) -> str:
    if "." in name or name in CURRENT:
        return name
    try:
        return parse_derivative(name).name
    except UnknownNameError:
        return name


def _fittable(model: Model) -> tuple[str, ...]:
    """Every name that may be identified."""
    names = []
    for effect, part in model.parts.items():
        known = part.known
        single = [item.name for item in known.parameters if not item.table]
        if effect in model.derivative_parts:
            names += [name for name in part.values if name not in single]
        names += [f"{effect}.{name}" for name in single if name in part.values]
    return (*names, *CURRENT)


def known_before(
    model: Model,
    asked: Sequence[str] | None,
    speed: float,
    *,
    prior: str | None,
    spread: float | None,
    extrapolate: bool,
) -> Prior:
    """The prior: of the model, or of another model or a derivative table.

    Parameters
    ----------
    model : Model
        Gives what `prior` does not have.
    asked : sequence of str, optional
        Derivatives (factors in any order), parameters with their effect, currents; by default all
        derivatives of the hull.
    speed : float
        Of the approach [m/s].
    prior : str, optional
        Library ship, model file or table file.
    spread : float, optional
        Relative standard deviation; it counts before a covariance.
    extrapolate : bool
        Allow a speed outside the range of values.

    Returns
    -------
    Prior
        Its origin says what came from where.
    """
    names = parameters_of(model, asked)
    own = Prior.of(model, names, speed, spread=spread, extrapolate=extrapolate)
    if prior is None:
        return replace(own, origin=f"{model.name}, {own.origin}")
    beside = ReferenceTable.of(prior)
    other, table = beside.model, beside.table
    if other is None or other.convention != model.convention:
        table = table if other is None else _with_covariance(table, other)
        return _from_table(own, table, model, speed, prior, spread, extrapolate)
    shared = [name for name in names if name in CURRENT or _has(other, name)]
    if not shared:
        raise UnknownNameError(f"{prior} has none of {', '.join(names)}.")
    given = Prior.of(other, shared, speed, spread=spread, extrapolate=extrapolate)
    return _joined(own, given, f"{prior}, {given.origin}")


def _has(model: Model, name: str) -> bool:
    try:
        places(model, [name])
    except UnknownNameError:
        return False
    return True


def _with_covariance(table: DerivativeTable, model: Model) -> DerivativeTable:
    """The derivatives of a model with the covariance that it carries."""
    if model.covariance is None:
        return table
    shared = [name for name in table.names if name in model.covariance_names]
    at = [table.names.index(name) for name in shared]
    of = [model.covariance_names.index(name) for name in shared]
    k, size = len(table.Fn), len(model.covariance_names)
    full = model.covariance.reshape(k, size, k, size)
    covariance = np.full_like(table.covariance, np.nan)
    for i, a in zip(at, of, strict=True):
        for j, b in zip(at, of, strict=True):
            covariance[:, i, :, j] = full[:, a, :, b]
    return table.with_(covariance=covariance)


def _from_table(
    own: Prior,
    table: DerivativeTable,
    model: Model,
    speed: float,
    source: str,
    spread: float | None,
    extrapolate: bool,
) -> Prior:
    """Values and covariance of a table at the speed, in the convention of the model."""
    same = table if table.convention == model.convention else converted(table, model.convention)
    froude = model.ship.froude(speed, model.water.g)
    at = interpolate(same, froude, extrapolate=extrapolate)
    known = [name for name in own.names if name in at.names and np.isfinite(at[name][0])]
    if not known:
        raise UnknownNameError(
            f"{source} has none of {', '.join(own.names)}; it has {', '.join(at.names)}."
        )
    columns = [at.index(name) for name in known]
    mean = at.value[0, columns]
    covariance = at.covariance[0][:, 0][np.ix_(columns, columns)].copy()
    sure = np.isfinite(np.diagonal(covariance)) & (np.diagonal(covariance) > 0) & (spread is None)
    sizes = np.where(mean != 0.0, np.abs(mean), 0.0)
    fallback = np.array([own.std[own.names.index(name)] for name in known])
    relative = np.where(sizes > 0.0, (spread or 0.3) * sizes, fallback)
    covariance = np.where(np.outer(sure, sure) & np.isfinite(covariance), covariance, 0.0)
    covariance[np.diag_indices_from(covariance)] += np.where(sure, 0.0, relative**2)
    told = f"the covariance of {source} for {int(sure.sum())} of {len(known)}"
    if not sure.all():
        told += f", else {100 * (spread or 0.3):g} % of each value"
    given = Prior(names=tuple(known), mean=mean, covariance=covariance, origin=told)
    return _joined(own, given, told)


def _joined(own: Prior, given: Prior, told: str) -> Prior:
    """What is given where it is, the model's own elsewhere."""
    mean, covariance = own.mean.copy(), own.covariance.copy()
    at = [own.names.index(name) for name in given.names]
    covariance[at, :] = 0.0
    covariance[:, at] = 0.0
    covariance[np.ix_(at, at)] = given.covariance
    mean[at] = given.mean
    rest = [name for name in own.names if name not in given.names]
    more = f"; of the model itself: {', '.join(rest)}" if rest else ""
    return Prior(names=own.names, mean=mean, covariance=covariance, origin=told + more)
