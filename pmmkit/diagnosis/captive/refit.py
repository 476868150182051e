"""From a joint fit to a model: derivatives with their covariance, effects with their values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pmmkit.base import ModelError, Problem, UnknownNameError
from pmmkit.campaigns import Campaign
from pmmkit.conventions import Convention, Structure, parse_derivative
from pmmkit.diagnosis.captive.base import CaptiveBase
from pmmkit.diagnosis.captive.candidate import Candidate, candidate_of
from pmmkit.diagnosis.captive.least_squares import JointFit, labels
from pmmkit.diagnosis.captive.system import CandidateColumns
from pmmkit.diagnosis.refit import put_back
from pmmkit.effects import BY_SPEED, CATALOGUE, HULL, Effect
from pmmkit.models import DerivativeTable, Model, converted, with_effect, without_effect
from pmmkit.numerics import Array
from pmmkit.presentation import WIDE

# Which effects of the catalogue captive tests are asked for.


def captive_candidates(
    speeds: Sequence[float] = (), own: Sequence[Effect] = ()
) -> tuple[Candidate, ...]:
    """Every effect and fault that captive tests can be asked for.

    speeds [m/s].

    Examples
    --------
    >>> "memory" in [item.name for item in captive_candidates()]
    True
    """
    every = {item.name: item for item in (*CATALOGUE.values(), *own)}
    asked = (candidate_of(item, speeds) for item in every.values() if item.asked_in_captive)
    return tuple(item for item in asked if item.grid)


def eligible(
    base: CaptiveBase, speeds: Sequence[float], own: Sequence[Effect] = ()
) -> tuple[Candidate, ...]:
    """The catalogue and effects of the user, without what the base has already.

    speeds [m/s].
    """
    known = {name for names in base.names.values() for name in names}
    return tuple(
        item for item in captive_candidates(speeds, own) if not set(item.coefficients) <= known
    )


def fitted_table(
    fit: JointFit,
    base: CaptiveBase,
    campaign: Campaign,
    Fn: Sequence[float] = (),
    own: Sequence[Effect] = (),
) -> DerivativeTable:
    """The derivatives of a joint fit, those of effects that are derivatives among them."""
    rows = np.asarray(Fn, float) if len(Fn) else np.array([np.nan])
    law = [base.law(campaign.ship.speed(x, campaign.water.g)) if len(Fn) else 0.0 for x in rows]
    places = [_places(label, own) for label in fit.names]
    names = tuple(dict.fromkeys(name for each in places for name, _, _ in each))
    weights = np.zeros((len(rows), len(names), len(fit.names)))
    for column, each in enumerate(places):
        for name, share, by_speed in each:
            weight = np.array(law) if by_speed else np.ones(len(rows))
            weights[:, names.index(name), column] += share * weight
    shape = (len(rows), len(names))
    known = np.isfinite(fit.values)
    lost = np.any(weights[:, :, ~known] != 0.0, axis=2)
    inside = weights[:, :, known]
    value = np.where(lost, np.nan, inside @ fit.values[known])
    flat = inside.reshape(-1, int(known.sum()))
    covariance = flat @ fit.covariance[np.ix_(known, known)] @ flat.T
    covariance[lost.ravel()], covariance[:, lost.ravel()] = np.nan, np.nan
    return DerivativeTable(
        names=names,
        Fn=rows,
        value=value,
        covariance=covariance.reshape(*shape, *shape),
        dof=np.full(shape, np.inf),
        method=np.full(shape, "joint fit"),
        runs=np.full(shape, len(campaign.runs)),
        convention=base.convention,
        ship=campaign.ship,
        water=campaign.water,
    )


def _places(label: str, own: Sequence[Effect]) -> tuple[tuple[str, float, bool], ...]:
    """The derivatives that a coefficient of a fit adds to, each with the share and whether with the
    speed; none if its effect is no derivative."""
    effect, _, name = label.rpartition(": ")
    entry = _entry(effect, own) if effect else None
    shares: Mapping[str, float] = {name: 1.0}
    if entry is not None:
        if entry.kind != "terms":
            return ()
        shares = entry.derivatives_of(name)
    return tuple(
        (plain, share, plain != derivative)
        for derivative, share in shares.items()
        if _is_derivative(plain := derivative.removesuffix(BY_SPEED))
    )


def _is_derivative(name: str) -> bool:
    try:
        parse_derivative(name)
    except UnknownNameError:
        return False
    return True


def _entry(name: str, own: Sequence[Effect]) -> Effect | None:
    """An effect of the user or of the catalogue; None for a candidate that is neither."""
    return next((item for item in own if item.name == name), CATALOGUE.get(name))


def refitted(
    model: Model,
    fit: JointFit,
    effects: Sequence[CandidateColumns],
    base: CaptiveBase,
    campaign: Campaign,
    own: Sequence[Effect] = (),
) -> tuple[Model, tuple[str, ...]]:
    """A model with the values of a joint fit, and what could not be taken over."""
    varies = any(by_speed for label in fit.names for _, _, by_speed in _places(label, own))
    Fn = (model.Fn or froude_numbers(campaign)) if varies else ()
    table = in_convention(fit, base, campaign, model.convention, Fn, own)
    known = [name for name in table.names if np.isfinite(table[name]).all()]
    kept = [name for name in table.names if name not in known]
    places = DerivativePlaces.of(model)
    left = [name for name in known if not places.hold(name)]
    notes = []
    if kept:
        notes.append(f"Not determined by these runs, kept as they were: {', '.join(kept)}.")
    if left:
        notes.append(f"Fitted, but the model has no place for them: {', '.join(left)}.")
    taken = table.select([name for name in known if name not in left])
    parts = [
        (entry, block)
        for block in effects
        if (entry := _entry(block.candidate.name, own)) is not None and entry.enters
    ]
    source = f"measured: {campaign.title or campaign.ship.name}"
    made = model.with_(convention=_target(model.convention))
    for entry, block in parts:
        made = _with_part(made, entry, block, fit, froude_numbers(campaign), source)
    derivatives = {
        (model.home_of(name), name): tuple(taken[name].tolist()) if len(Fn) else taken[name].item()
        for name in taken.names
    }
    coefficients = {
        (entry.name, name): value
        for entry, block in parts
        for name, value in made.parts[entry.name].values.items()
        if name in block.candidate.coefficients
    }
    beside = [
        f"{block.candidate.name}: {name}"
        for _, block in parts
        for name in block.candidate.coefficients
    ]
    known_places = (*derivatives, *coefficients)
    made = put_back(
        made,
        values={**derivatives, **coefficients},
        known=known_places,
        covariance=_together(fit, beside, taken, base, campaign, model.convention, Fn, own),
        sources=dict.fromkeys(known_places, source),
        Fn=tuple(Fn),
    )
    return made, tuple(notes)


@dataclass(frozen=True, kw_only=True)
class DerivativePlaces:
    """Whether a model has places for derivatives of the rudder, and of roll."""

    steered: bool
    rolls: bool

    @classmethod
    def of(cls, source: Model | str | Sequence[str] | Structure) -> DerivativePlaces:
        """Of a model, or of what is made of a structure or of derivatives."""
        if isinstance(source, Model):
            return cls(steered="rudder_abkowitz" in source.parts, rolls=source.rolls)
        stated = [parse_derivative(x) for x in Structure.meant_by(source).derivatives]
        return cls(steered=any(x.count("d") for x in stated), rolls=any(x.rolls for x in stated))

    def hold(self, name: str) -> bool:
        """Whether there is a place for a derivative."""
        known = parse_derivative(name)
        return (self.steered or not known.count("d")) and (self.rolls or not known.rolls)


def _together(
    fit: JointFit,
    beside: Sequence[str],
    taken: DerivativeTable,
    base: CaptiveBase,
    campaign: Campaign,
    convention: Convention,
    Fn: Sequence[float],
    own: Sequence[Effect],
) -> Array:
    """Covariance of derivatives, as a table has them, and of coefficients that are none, at one
    Froude number after another.

    The derivatives of a table are those of the fit by an affine map: a coefficient of deviation s
    moves them as C e / s of the fit's values does.
    """
    rows, count = taken.value.shape
    n, m = rows * count, len(beside)
    at = [fit.names.index(label) for label in beside]
    cross = np.zeros((rows, count, m))
    for k, place in enumerate(at):
        size = fit.std[place]
        moved = replace(fit, values=fit.values + fit.covariance[:, place] / size)
        table = in_convention(moved, base, campaign, convention, Fn, own).select(taken.names)
        cross[:, :, k] = size * (table.value - taken.value)
    whole = np.empty((rows, count + m, rows, count + m))
    whole[:, :count, :, :count] = taken.covariance
    whole[:, :count, :, count:] = cross[:, :, None, :]
    whole[:, count:, :, :count] = np.moveaxis(cross, 2, 0)[None]
    whole[:, count:, :, count:] = fit.covariance[np.ix_(at, at)][None, :, None, :]
    return whole.reshape(n + rows * m, n + rows * m)


def _with_part(
    model: Model,
    effect: Effect,
    block: CandidateColumns,
    fit: JointFit,
    Fn: Sequence[float],
    source: str,
) -> Model:
    """A model with an effect that is a part of its own, at the values of a fit."""
    c = block.candidate
    values, std = fit.of(labels(c))
    _refuse_impossible(effect, c.coefficients, values, std)
    bare = without_effect(model, effect) if c.name in model.parts else model
    made = with_effect(
        bare,
        effect,
        value=block.value,
        Fn=Fn,
        coefficients=dict(zip(c.coefficients, values.tolist(), strict=True)),
        source=source,
    )
    return made.with_(steps=model.steps)


def _refuse_impossible(effect: Effect, names: Sequence[str], values: Array, std: Array) -> None:
    """Refuse coefficients that the effect cannot have; tests that ask for them show it not."""
    problems = []
    for name, value, spread in zip(names, values.tolist(), std.tolist(), strict=True):
        known = effect.parameter(name)
        if known is not None and not known.low <= value <= known.high:
            limit = f"below {known.low:g}" if value < known.low else f"above {known.high:g}"
            problems.append(
                Problem(
                    message=f"these tests put {name} of {effect.name} at {value:.3g} ± "
                    f"{WIDE * spread:.2g}, and it cannot be {limit}.",
                    remedy="They do not show this effect: leave it out"
                    + (f", or make the test that does: {effect.check}." if effect.check else "."),
                )
            )
    if problems:
        raise ModelError(problems)


def places_of(block: CandidateColumns, model: Model, own: Sequence[Effect] = ()) -> tuple[str, ...]:
    """Parts and values (``hull_polynomial.Yvvr``) of a model that an effect of a fit stands in."""
    c = block.candidate
    if c.name in model.parts:
        return (c.name,)
    names = dict.fromkeys(name for label in labels(c) for name, _, _ in _places(label, own))
    return tuple(f"{model.home_of(name)}.{name}" for name in names)


def in_convention(
    fit: JointFit,
    base: CaptiveBase,
    campaign: Campaign,
    convention: Convention,
    Fn: Sequence[float] = (),
    own: Sequence[Effect] = (),
) -> DerivativeTable:
    """`fitted_table` by a model's convention, as near to it as a table can be converted."""
    return converted(fitted_table(fit, base, campaign, Fn, own), _target(convention))


def _target(convention: Convention) -> Convention:
    """What a table can be converted to: expansions about other points cannot be reached."""
    surge = "u" if convention.surge == "delta-u" else convention.surge
    return replace(convention, surge=surge, U="instantaneous")


def froude_numbers(campaign: Campaign) -> tuple[float, ...]:
    """Froude numbers of the runs of a campaign, ascending."""
    numbers = {
        round(campaign.ship.froude(run.settings.speed, campaign.water.g), 6)
        for run in campaign.runs
    }
    return tuple(sorted(numbers))


def effects_of(model: Model) -> tuple[str, ...]:
    """What of a model is fitted beside its derivatives."""
    parts = [name for name, part in model.parts.items() if part.known.asked_in_captive]
    varying = [
        effect.name
        for effect in CATALOGUE.values()
        if any(_varies(model, name) for name in effect.varies_with_speed)
    ]
    faults = [step.effect for step in model.steps if step.action == "fault_corrected"]
    return tuple(dict.fromkeys([*parts, *varying, *faults]))


def written_in(model: Model | None, own: Sequence[Effect] = ()) -> tuple[Effect, ...]:
    """Effects of the user: those that are given, and those that a model holds as text."""
    parts = model.parts.values() if model else ()
    held = {part.effect: part.known for part in parts if part.text}
    return tuple({**held, **{item.name: item for item in own}}.values())


def _varies(model: Model, name: str) -> bool:
    """Whether a model has different values of a derivative at its Froude numbers."""
    value = model.parts[HULL].values.get(name) if HULL in model.parts else None
    return isinstance(value, tuple) and len(set(value)) > 1
