"""Effects that a diagnosis names, put into a model and taken out again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Literal, Protocol

from pmmkit.base import ModelError, Problem, Remedy, UnknownNameError, Way, did_you_mean
from pmmkit.conventions import parse_derivative
from pmmkit.effects import BY_SPEED, CATALOGUE, Effect, Move, Parameter
from pmmkit.models.model import Model
from pmmkit.models.part import Part
from pmmkit.models.step import Before, Step, Value
from pmmkit.models.terms import RequestedEffect, reference, with_terms, without_terms
from pmmkit.models.vessel import Sailing


class Found(Protocol):
    """What is taken from a finding of a diagnosis."""

    @property
    def effect(self) -> str:
        """Name of the effect."""

    @property
    def coefficients(self) -> Mapping[str, float]:
        """Fitted values."""

    @property
    def value(self) -> float:
        """Grid value of its nonlinear parameter."""

    @property
    def beside(self) -> bool:
        """Whether the coefficients come to values that the model has."""


Named = str | Effect | Found
Sizes = Mapping[str, float] | Literal["typical"] | None


def with_effect(
    model: Model,
    effect: Named | Sequence[Named],
    *,
    coefficients: Sizes = None,
    value: float | None = None,
    Fn: Sequence[float] = (),
    source: str = "",
) -> Model:
    """A model with an effect that it lacked.

    Parameters
    ----------
    model : Model
        The model.
    effect : str, Finding, Effect or sequence of them
        A name of the catalogue, a finding of `diagnose`, an effect of one's own, or several at
        once (``finding.best``).
    coefficients : mapping of str to float, or "typical", optional
        As the diagnosis gives them: prime system, speed of the instant, Coriolis terms of the
        added mass inside. By default those of the finding; zero where only a name is given, to be
        fitted. ``"typical"``: of usual size. What a model has by values of a part of its own
        (``rudder_stall`` of a ``rudder_mmg``: ``stall_loss``, ``stall_deg``) is put in that way,
        unless derivatives are given.
    value : float, optional
        Nonlinear parameter: the lag in L/U, the growth of CD to the ends. By default that of the
        finding, or one in the middle of the usual ones.
    Fn : sequence of float
        Froude numbers of the tests, for effects of the speed; by default those of the model.
    source : str
        Where the values come from, for the model file.

    Returns
    -------
    Model
        Derivatives go into the hull polynomial (those of the rudder into its polynomial where there
        is one) in the convention of the model, other effects become parts. What a derivative that
        is there already would gain is left out.

    Raises
    ------
    ModelError
        If the effect is a fault of a measurement, is there already, or needs what the model lacks.
    UnknownNameError
        If there is no such effect.

    Examples
    --------
    >>> from pmmkit.models.store import load_model
    >>> slow = with_effect(load_model("s175-3dof"), "memory", coefficients={"Yv_late": -0.002})
    >>> slow.values("memory")
    {'Yv_late': -0.002, 'Nv_late': 0.0, 'lag': 0.5}
    """
    several = _listed(effect)
    if not several:
        raise ModelError("There is no effect to add: the diagnosis named none.")
    if len(several) > 1 and (value is not None or isinstance(coefficients, Mapping)):
        raise ModelError("Coefficients and values are given for one effect at a time.")
    for item in several:
        asked = _asked(model, item, coefficients, value, tuple(float(x) for x in Fn), source)
        beside = not isinstance(item, (str, Effect)) and item.beside
        there = asked.name in model.parts or not asked.effect.enters
        if asked.effect.kind == "freed" or asked.moved or (beside and there):
            model = _with_moved(model, asked)
        elif asked.effect.enters:
            model = _with_part(model, asked)
        else:
            model = with_terms(model, asked)
    return model


def without_effect(model: Model, effect: Named | Sequence[Named]) -> Model:
    """A model without an effect: `with_effect` undone.

    Parameters
    ----------
    model : Model
        The model.
    effect : str, Finding, Effect or sequence of them
        As for `with_effect`.

    Returns
    -------
    Model
        Derivatives of the effect are taken out whoever put them in; a change with the Froude number
        is taken out of the values, what it leaves at Fn0 stays.

    Raises
    ------
    ModelError
        If the model does not have it.

    Examples
    --------
    >>> from pmmkit.models.store import load_model
    >>> plain = without_effect(load_model("s175-3dof"), "yaw_sway_coupling")
    >>> "Nvvr" in plain.values("hull_polynomial")
    False
    """
    for item in _listed(effect):
        asked = _asked(model, item, None, None, (), "")
        if asked.effect.kind == "freed" or _was_moved(model, asked):
            model = _moved_back(model, asked.name)
        elif asked.effect.enters:
            if asked.name not in model.parts:
                raise ModelError(f"Model {model.name!r} has no part {asked.name!r}.")
            model = model.without_values([asked.name])
        else:
            if asked.moved:
                terms = MappingProxyType(dict.fromkeys(asked.effect.typical, 0.0))
                asked = replace(asked, coefficients=terms)
            model = without_terms(model, asked)
        model = model.stepped(Step(action="effect_removed", effect=asked.name))
    return model


def _listed(effect: Named | Sequence[Named]) -> list[Named]:
    if isinstance(effect, Sequence) and not isinstance(effect, str):
        return list(effect)
    return [effect]


def _asked(
    model: Model,
    effect: Named,
    coefficients: Sizes,
    value: float | None,
    Fn: tuple[float, ...],
    source: str,
) -> RequestedEffect:
    """What is asked for, checked against what there is."""
    given: Mapping[str, float] | None = None
    named = isinstance(effect, Effect | str)
    if isinstance(effect, Effect | str):
        entry = effect if isinstance(effect, Effect) else CATALOGUE[effect]
        asked_here = entry.kind == "terms" and entry.moves is not None
    else:
        given = effect.coefficients
        value = effect.value if value is None else value
        entry = CATALOGUE[effect.effect] if effect.effect in CATALOGUE else _found(effect)
        asked_here = effect.beside
    _refuse(entry)
    own: Mapping[str, Move] = {}
    if asked_here and not entry.faulty:
        own = Sailing(model, 1.0).moves(entry)
    origin = "diagnosis" if given is not None else "assumed: zero, to be fitted"
    if coefficients == "typical":
        given, origin = None, "assumed: usual size"
    elif isinstance(coefficients, Mapping):
        given, origin = coefficients, "given"
    known = {**entry.typical, **own}
    stray = [label for label in given or {} if entry.typical and label not in known]
    if stray:
        raise UnknownNameError(
            f"{entry.name} has no coefficient {', '.join(stray)}"
            f"{did_you_mean(stray[0], known) or '.'} It has {', '.join(known)}."
        )
    moved = named and _by_parts(own) and not (given and set(given) <= set(entry.typical))
    usual = {x: move.typical for x, move in own.items()} if named and own else entry.typical
    if given is not None and not moved:
        usual = entry.typical
    sizes = usual if coefficients == "typical" else given or {}
    return RequestedEffect(
        effect=entry,
        coefficients=MappingProxyType({**dict.fromkeys(usual, 0.0), **sizes}),
        known=given is not None or coefficients == "typical",
        value=value,
        Fn=Fn,
        source=source or f"{origin} ({entry.name})",
        moved=moved,
    )


def _by_parts(moves: Mapping[str, Move]) -> bool:
    """Whether a model has an effect of derivatives by values of parts of its own."""
    return bool(moves) and all("." in place for move in moves.values() for place in move.values)


def _found(finding: Found) -> Effect:
    """A finding that is in no catalogue, if its coefficients are derivatives."""
    lost = [label for label in finding.coefficients if not _derivative(label)]
    if lost:
        raise ModelError(
            Problem(
                message=f"The finding {finding.effect} has coefficients that are no derivatives "
                f"({', '.join(lost)}).",
                remedy=Remedy(
                    "Give the own effect itself, with coefficients = those of the finding, or {}.",
                    (Way("register it first (pmmkit.register_effect)", "its file with --own"),),
                ),
            )
        )
    return Effect(
        name=finding.effect,
        family="own",
        kind="terms",
        summary="",
        parameters=tuple(
            Parameter(name=label, text="", typical=size)
            for label, size in finding.coefficients.items()
        ),
    )


def _refuse(entry: Effect) -> None:
    if entry.faulty:
        raise ModelError(
            f"{entry.name} is a fault of the measurement: it corrects the data, it does not enter "
            f"a model. {entry.summary}{f' To be sure: {entry.check}.' if entry.check else ''}"
        )
    if not entry.coefficients and entry.moves is None:
        raise ModelError(
            f"{entry.name} is a part with particulars of its own: write it into the model file "
            f"([effects.{entry.name}]) or take it from a library ship."
        )


def _derivative(label: str) -> bool:
    try:
        return parse_derivative(label.removesuffix(BY_SPEED)).name == label.removesuffix(BY_SPEED)
    except UnknownNameError:
        return False


def _with_part(model: Model, asked: RequestedEffect) -> Model:
    """The model with an effect that is a part of its own."""
    entry = asked.effect
    if asked.name in model.parts:
        raise ModelError(
            f"Model {model.name!r} has the effect {asked.name} already: change its values, or take "
            f"it out first (without_effect)."
        )
    values: dict[str, Value] = dict(asked.coefficients)
    options: dict[str, str] = {}
    inner = entry.nonlinear
    if inner is not None:
        value = inner.grid[len(inner.grid) // 2] if asked.value is None else asked.value
        if inner.form is None or value:
            values[inner.name] = value
            options = {inner.form[0]: inner.form[1]} if inner.form else {}
    if entry.parameter("Fn0") is not None:
        values["Fn0"] = reference(model, asked)
    part = Part(
        effect=asked.name,
        values=MappingProxyType(values),
        options=MappingProxyType(options),
        source=asked.source,
        text=entry.text,
    )
    made = replace(model, parts=MappingProxyType({**model.parts, asked.name: part}))
    tried = values.get(inner.name) if inner is not None else None
    return made.stepped(
        Step(
            action="effect_added",
            effect=asked.name,
            coefficients=MappingProxyType(dict(asked.coefficients)),
            system="prime",
            parameter=inner.name if inner is not None and tried is not None else "",
            value=tried if isinstance(tried, float | int) else None,
            Fn=asked.Fn,
            numbers=MappingProxyType({"Fn0": values["Fn0"]} if "Fn0" in values else {}),
            source=asked.source,
            before=Before(absent=(asked.name,)),
        )
    )


def _with_moved(model: Model, asked: RequestedEffect) -> Model:
    """The model with values that an effect moves."""
    moves = Sailing(model, 1.0).moves(asked.effect)
    if not moves:
        raise ModelError(
            f"{asked.name} moves values of {asked.effect.frees}, which model {model.name!r} does "
            f"not have."
        )
    moved = {label for label, size in asked.coefficients.items() if size}
    if moved and asked.known and not moves.keys() & moved:
        raise ModelError(
            f"{asked.name} moves {', '.join(moves)} of model {model.name!r}, and was found as "
            f"{', '.join(asked.coefficients)} of another one: diagnose with this model."
        )
    made = model
    for move in moves.values():
        made = Sailing(made, 1.0).told(move.options, move.begins)
    if asked.moved and not moved and made is model:
        raise ModelError(
            f"Model {model.name!r} has {asked.name} already: change its values "
            f"({', '.join(place for move in moves.values() for place in move.values)})."
        )
    parts = dict(made.parts)
    for label, size in asked.coefficients.items():
        for place, share in moves[label].values.items() if label in moves else ():
            home, _, name = place.rpartition(".")
            home = home or model.home_of(name)
            part = parts[home]
            before = part.known.parameter(name)
            known = part.values.get(name, before.default if before is not None else 0.0) or 0.0
            parts[home] = replace(
                part,
                values=MappingProxyType({**part.values, name: _more(known, share * size)}),
                sources=MappingProxyType(
                    {**part.sources, name: f"{part.source_of(name)}; {asked.source}"}
                ),
            )
    made = replace(made, parts=MappingProxyType(parts))
    return made.stepped(
        Step(
            action="effect_added",
            effect=asked.name,
            coefficients=MappingProxyType(
                {x: y for x, y in asked.coefficients.items() if x in moves}
            ),
            source=asked.source,
            before=model.before(made),
        )
    )


def _more(value: Value, size: float) -> Value:
    return tuple(x + size for x in value) if isinstance(value, tuple) else value + size


def _was_moved(model: Model, asked: RequestedEffect) -> bool:
    """Whether an effect of derivatives came to a model by the values of another part."""
    own = [step for step in model.steps if step.effect == asked.name and step.before is not None]
    return bool(own) and not own[-1].coefficients.keys() & asked.effect.typical.keys()


def _moved_back(model: Model, name: str) -> Model:
    """The model with the values that the last step of an effect moved as they were."""
    own = [step for step in model.steps if step.effect == name and step.before is not None]
    if not own or own[-1].before is None:
        raise ModelError(
            f"The history of {model.name!r} does not say what {name} changed: give the values "
            f"themselves."
        )
    return model.restored(own[-1].before)
