"""Effects that a diagnosis names, put into a model and taken out again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Literal, Protocol

from pmmkit.conventions import canonical
from pmmkit.effects.catalogue import catalogue, effect_of
from pmmkit.effects.effect import BY_SPEED, Effect
from pmmkit.errors import ModelError, UnknownNameError
from pmmkit.models import Model, Part
from pmmkit.models.model import Value
from pmmkit.models.terms import Asked, added, reference, told, with_terms, without_terms


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
        fitted. ``"typical"``: of usual size.
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
    >>> from pmmkit.models import load_model
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
        asked = _asked(item, coefficients, value, tuple(float(x) for x in Fn), source)
        entry = catalogue().get(asked.name)
        model = (
            _with_part(model, asked, entry) if entry and entry.enters else with_terms(model, asked)
        )
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
    >>> from pmmkit.models import load_model
    >>> plain = without_effect(load_model("s175-3dof"), "yaw_sway_coupling")
    >>> "Nvvr" in plain.values("hull_polynomial")
    False
    """
    several = _listed(effect)
    for item in several:
        asked = _asked(item, None, None, (), "")
        entry = catalogue().get(asked.name)
        if entry and entry.enters:
            if asked.name not in model.parts:
                raise ModelError(f"Model {model.name!r} has no part {asked.name!r}.")
            parts = {name: part for name, part in model.parts.items() if name != asked.name}
            model = replace(model, parts=MappingProxyType(parts))
        else:
            model = without_terms(model, asked)
        model = told(model, f"Effect {asked.name} taken out.")
    return model


def _listed(effect: Named | Sequence[Named]) -> list[Named]:
    if isinstance(effect, Sequence) and not isinstance(effect, str):
        return list(effect)
    return [effect]


def _asked(
    effect: Named, coefficients: Sizes, value: float | None, Fn: tuple[float, ...], source: str
) -> Asked:
    """What is asked for, checked against what there is."""
    typical: Mapping[str, float]
    given: Mapping[str, float] | None = None
    if isinstance(effect, Effect):
        name, shares, typical = effect.name, effect.shares, effect.typical
    else:
        if isinstance(effect, str):
            name = effect
        else:
            name, given = effect.effect, effect.coefficients
            value = effect.value if value is None else value
        if name in catalogue() or given is None:
            entry = effect_of(name)
            _refuse(entry)
            typical = {item.name: item.typical or 0.0 for item in entry.coefficients}
            shares = {label: {label: 1.0} for label in typical}
        else:
            typical, shares = given, {label: {label: 1.0} for label in given}
            lost = [label for label in given if not _derivative(label)]
            if lost:
                raise ModelError(
                    f"The finding {name} has coefficients that are no derivatives "
                    f"({', '.join(lost)}). Give the own effect itself, with coefficients = those "
                    f"of the finding; one written in Python needs a file in pmmkit/effects/."
                )
    origin = "diagnosis" if given is not None else "assumed: zero, to be fitted"
    if coefficients == "typical":
        given, origin = typical, "assumed: usual size"
    elif isinstance(coefficients, Mapping):
        given, origin = coefficients, "given"
    stray = [label for label in given or {} if label not in shares]
    if stray:
        raise UnknownNameError(
            f"{name} has no coefficient {', '.join(stray)}; it has {', '.join(shares)}."
        )
    return Asked(
        name=name,
        shares=shares,
        coefficients={label: (given or {}).get(label, 0.0) for label in shares},
        known=given is not None,
        value=value,
        Fn=Fn,
        source=source or f"{origin} ({name})",
    )


def _refuse(entry: Effect) -> None:
    if entry.faulty:
        raise ModelError(
            f"{entry.name} is a fault of the measurement: it corrects the data, it does not enter "
            f"a model. {entry.summary} To be sure: {entry.check}."
        )
    if not entry.coefficients:
        raise ModelError(
            f"{entry.name} is a part with particulars of its own: write it into the model file "
            f"([effects.{entry.name}]) or take it from a library ship."
        )


def _derivative(label: str) -> bool:
    try:
        return canonical(label.removesuffix(BY_SPEED)) == label.removesuffix(BY_SPEED)
    except UnknownNameError:
        return False


# An effect with a function: a part of its own


def _with_part(model: Model, asked: Asked, entry: Effect) -> Model:
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
    )
    made = replace(model, parts=MappingProxyType({**model.parts, asked.name: part}))
    return told(made, added(asked.name, values))
