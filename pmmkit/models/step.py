"""Steps: what was done to a model, as data; sentences are made from them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import MISSING, Field, dataclass, field, fields, is_dataclass
from types import MappingProxyType
from typing import Any, Final, Literal, cast

from pmmkit.base import ModelError

Value = float | tuple[float, ...]
Action = Literal[
    "noted",
    "built",
    "forced",
    "estimated",
    "scaled",
    "friction_corrected",
    "wake_corrected",
    "effect_added",
    "effect_removed",
    "fault_corrected",
    "fitted",
    "identified",
    "terms_selected",
    "stated",
    "part_replaced",
]


def _none() -> Mapping[str, Any]:
    return MappingProxyType({})


@dataclass(frozen=True, kw_only=True)
class Before:
    """What a step changed, as it was: enough to take the step back.

    `absent`: parts, and values and options of parts (``hull_polynomial.Yvvr``,
    ``rudder_mmg.stall``), that were not there. `values`: values that were replaced. `sources`:
    sources that these values had of their own. `options`: words of options that were replaced.
    `pooled`: whether the model had no Froude numbers.
    """

    absent: tuple[str, ...] = ()
    values: Mapping[str, Value] = field(default_factory=_none)
    sources: Mapping[str, str] = field(default_factory=_none)
    options: Mapping[str, str] = field(default_factory=_none)
    pooled: bool = False


@dataclass(frozen=True, kw_only=True)
class Step:
    """One step that led to a model; its text is `str(step)`.

    Parameters
    ----------
    action : str
        What was done: ``built`` from a table, ``forced`` though that table is not usable (`names`
        says why), ``estimated``, ``scaled``, ``friction_corrected``,
        ``wake_corrected``, ``effect_added``, ``effect_removed``, ``fault_corrected`` (in the data,
        by the fit), ``fitted``, ``identified``, ``terms_selected``, values ``stated`` by hand,
        ``part_replaced``; ``noted`` is a text alone.
    effect : str
        Name of the effect or fault.
    coefficients : mapping of str to float or tuple of float
        Of the effect; those of a fault with their unit in the name.
    system : str
        Non-dimensional system of the coefficients: ``prime``, ``prime-d``, ``bis``.
    parameter, value : str, float
        Nonlinear parameter of the effect.
    Fn : tuple of float
        Froude numbers of the tests.
    log_odds : float, optional
        ln of the odds for the effect.
    error_before, error_after : float, optional
        Error of what is left out of the fit, without and with the effect.
    error_of : str
        What these are errors of: ``heading`` of records [deg]; by default all forces of captive
        tests, over their rms.
    campaign : str
        Title of the tests.
    count : int, optional
        Number of coefficients that were fitted together.
    faults : tuple of str
        Faults of the measurement that the fit corrected.
    names : tuple of str
        Values that were identified, or what makes the table of a forced model not usable.
    misfit : tuple of str
        What the table of a model that was built says of its misfit: notes that stand until an
        effect is fitted to tests together with the derivatives.
    left_out : tuple of str
        Terms that were left out, or that the model had before.
    numbers : mapping of str to float or tuple of float
        Other numbers of the step, SI: lengths [m], friction coefficients, wake fractions.
    source : str
        Where the coefficients come from.
    ship, parts : str
        Ship of the derivatives, and ship of the other parts.
    method : str
        Of an estimate or an identification.
    before : Before, optional
        What the step changed.
    note : str
        A remark: the reason, or the whole text of a step that is only noted.

    Raises
    ------
    ModelError
        If a number is not finite, or one that the action needs is absent.

    Examples
    --------
    >>> print(Step(action="fitted", count=21, campaign="S175"))
    Fitted 21 coefficients to S175.
    """

    action: Action
    effect: str = ""
    coefficients: Mapping[str, Value] = field(default_factory=_none)
    system: str = ""
    parameter: str = ""
    value: float | None = None
    Fn: tuple[float, ...] = ()
    log_odds: float | None = None
    error_before: float | None = None
    error_after: float | None = None
    error_of: str = ""
    campaign: str = ""
    count: int | None = None
    faults: tuple[str, ...] = ()
    names: tuple[str, ...] = ()
    misfit: tuple[str, ...] = ()
    left_out: tuple[str, ...] = ()
    numbers: Mapping[str, Value] = field(default_factory=_none)
    source: str = ""
    ship: str = ""
    parts: str = ""
    method: str = ""
    before: Before | None = None
    note: str = ""

    def __post_init__(self) -> None:
        found = [
            *(self.value, self.log_odds, self.error_before, self.error_after, self.Fn),
            *(x for part in (self.coefficients, self.numbers) for x in part.values()),
            *(self.before.values.values() if self.before else ()),
        ]
        wrong = []
        if not all(math.isfinite(x) for item in found if item is not None for x in _each(item)):
            wrong.append("has numbers that are not finite")
        lost = [name for name in NUMBERS.get(self.action, ()) if name not in self.numbers]
        if lost:
            wrong.append(f"lacks the numbers {', '.join(lost)}")
        if wrong:
            raise ModelError(f"A step {self.action!r} {' and '.join(wrong)}.")

    def __str__(self) -> str:
        return SENTENCES[self.action](self)

    @property
    def entries(self) -> dict[str, Any]:
        """Its fields that differ from their defaults, as plain data.

        Examples
        --------
        >>> Step(action="fitted", count=21, campaign="S175").entries
        {'action': 'fitted', 'campaign': 'S175', 'count': 21}
        """
        return _entries(self)


def _entries(record: object) -> dict[str, Any]:
    """The fields of a dataclass that differ from their defaults, as `toml_text` writes them."""
    return {
        item.name: _plain(value)
        for item in fields(cast(Any, record))
        if (value := getattr(record, item.name)) != _default(item)
    }


def _default(item: Field[Any]) -> object:
    return item.default if item.default_factory is MISSING else item.default_factory()


def _plain(value: object) -> object:
    if is_dataclass(value):
        return _entries(value)
    if isinstance(value, Mapping):
        return {name: _plain(x) for name, x in value.items()}
    return list(value) if isinstance(value, tuple) else value


def _each(value: Value) -> tuple[float, ...]:
    return value if isinstance(value, tuple) else (value,)


def _listed(value: Value, form: str, between: str = ", ") -> str:
    return between.join(f"{x:{form}}" for x in _each(value))


def odds(log_odds: float) -> str:
    """Odds in words, from their natural logarithm.

    Parameters
    ----------
    log_odds : float
        ln evidence of one explanation less that of another.

    Examples
    --------
    >>> odds(3.0), odds(80.0), odds(-3.0)
    ('about 20 to 1', 'over 1000 to 1', 'about 20 to 1 against')
    """
    if log_odds < 0.0:
        return f"{odds(-log_odds)} against"
    if log_odds > math.log(1000.0):
        return "over 1000 to 1"
    return f"about {math.exp(log_odds):.0f} to 1"


def faults_of(steps: Sequence[Step], campaign: str) -> dict[str, Step]:
    """The faults that a model's steps tell of some tests: of each the last step.

    A fault belongs to its laboratory: to the tests that the step names, by their title.

    Examples
    --------
    >>> found = [
    ...     Step(action="fault_corrected", effect="current", campaign=title,
    ...          coefficients={"current_x": x})
    ...     for title, x in (("a", 0.1), ("a", 0.2), ("b", 1.0))
    ... ]
    >>> faults_of(found, "a")["current"].coefficients, list(faults_of(found, "c"))
    ({'current_x': 0.2}, [])
    """
    return {
        step.effect: step
        for step in steps
        if step.action == "fault_corrected" and step.campaign == campaign
    }


def added(steps: Sequence[Step]) -> tuple[int, ...]:
    """Places of the steps that added what is still in a model: effects, and faults of the tests.

    Examples
    --------
    >>> into = [Step(action="effect_added", effect=name) for name in ("memory", "asymmetry")]
    >>> added([*into, Step(action="effect_removed", effect="asymmetry")])
    (0,)
    """
    there: list[int] = []
    for number, step in enumerate(steps):
        if step.action in ("effect_added", "fault_corrected"):
            there.append(number)
        elif step.action == "effect_removed":
            same = [i for i in there if steps[i].effect == step.effect]
            there = [i for i in there if i not in same[-1:]]
    return tuple(there)


# The sentence of each action


def _added(step: Step) -> str:
    if step.error_before is not None:
        return _explained(step)
    inner = {} if step.value is None else {step.parameter: step.value}
    values = {**step.coefficients, **inner, **step.numbers}
    said = ", ".join(f"{name} = {_listed(x, '.4g', ' | ')}" for name, x in values.items())
    left = f" It had {', '.join(step.left_out)} before." if step.left_out else ""
    note = f" {step.note[0].upper()}{step.note[1:]}." if step.note else ""
    return f"Effect {step.effect} added: {said}.{left}{note}"


def _explained(step: Step) -> str:
    """What a fit took in, with the error that it takes away."""
    why = step.note or ("" if step.log_odds is None else odds(step.log_odds))
    before, after = (
        "unknown" if x is None else f"{x:.3g}°" if step.error_of else f"{100 * x:.2f} %"
        for x in (step.error_before, step.error_after)
    )
    of = f" of {step.campaign}" if step.campaign else ""
    if step.error_of:
        fall = f"{step.error_of} {before} to {after} where records{of} are left out"
    else:
        fall = f"left-out conditions {before} to {after} of the rms forces{of}"
    # The numbers of a fault stand in no part of the model.
    numbers = step.coefficients.items() if step.action == "fault_corrected" else ()
    said = "".join(f", {name} = {_listed(x, '.4g', ' | ')}" for name, x in numbers)
    return f"Added {step.effect}{said}{f' ({why})' if why else ''}: error of {fall}."


def _fitted(step: Step) -> str:
    faults = f", {', '.join(step.faults)} corrected" if step.faults else ""
    return f"Fitted {step.count} coefficients to {step.campaign or 'records'}{faults}."


def _scaled(step: Step) -> str:
    old, new = (_listed(step.numbers[name], "g") for name in ("length_before", "length"))
    return f"Scaled from L = {old} m to {new} m by Froude's law."


def _friction(step: Step) -> str:
    x = step.numbers
    return (
        f"Friction by ITTC 1957 with k = {_listed(x['form'], '.3f')}, wetted surface "
        f"{_listed(x['wetted'], '.5g')} m², roughness {_listed(x['roughness_um'], '.0f')} µm "
        f"(ΔCF {_listed(x['roughness_allowance'], '.2e')}): CF {_listed(x['CF_model'], '.3e')} of "
        f"the model, {_listed(x['CF_ship'], '.3e')} of the ship; Xuu gains "
        f"{_listed(x['Xuu_gain'], '.5f')}: the propulsion point of the ship."
    )


def _wake(step: Step) -> str:
    model, ship = (_listed(step.numbers[name], ".3f") for name in ("wp_model", "wp_ship"))
    return f"Wake by ITTC 1978: wp {model} of the model, {ship} of the ship."


def _because(step: Step) -> str:
    return f", because {step.note}" if step.note else ""


def _stated(step: Step) -> str:
    said = ", ".join(f"{name} = {_listed(x, '.5g', ' | ')}" for name, x in step.numbers.items())
    return f"Stated: {said}{_because(step)}."


SENTENCES: Final[Mapping[Action, Callable[[Step], str]]] = MappingProxyType(
    {
        "noted": lambda step: step.note,
        "built": lambda step: f"Derivatives of {step.ship} joined with the parts of {step.parts}.",
        "forced": lambda step: (
            f"Made by force, for the derivatives of {step.ship} are not usable: "
            f"{' '.join(step.names)}"
        ),
        "estimated": lambda step: f"Estimated by {step.method}.",
        "scaled": _scaled,
        "friction_corrected": _friction,
        "wake_corrected": _wake,
        "effect_added": _added,
        "effect_removed": lambda step: f"Effect {step.effect} taken out.",
        "fault_corrected": _added,
        "fitted": _fitted,
        "identified": lambda step: f"{len(step.names)} values identified by {step.method}.",
        "terms_selected": lambda step: (
            f"Sparse regression: {', '.join(step.names)} fitted; left out: "
            f"{', '.join(step.left_out) or 'none'}."
        ),
        "stated": _stated,
        "part_replaced": lambda step: (
            f"Part {step.effect} taken from {step.parts}{_because(step)}."
        ),
    }
)
NUMBERS: Final[Mapping[Action, tuple[str, ...]]] = MappingProxyType(
    {
        "scaled": ("length_before", "length"),
        "friction_corrected": (
            "form",
            "wetted",
            "roughness_um",
            "roughness_allowance",
            "CF_model",
            "CF_ship",
            "Xuu_gain",
        ),
        "wake_corrected": ("wp_model", "wp_ship"),
    }
)
"""What `numbers` must hold, by action."""
