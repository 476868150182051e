"""Effects that are derivatives: into the polynomials of a model, in its convention, and out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from pmmkit.base import ModelError, Problem, Remedy, Way
from pmmkit.conventions import Convention, parse_derivative
from pmmkit.effects import BY_SPEED, INERTIA, Effect
from pmmkit.models.model import Model
from pmmkit.models.part import Part, needs_roll
from pmmkit.models.step import Step, Value
from pmmkit.models.tables.convert import converted
from pmmkit.models.tables.table import from_values
from pmmkit.numerics import Array


@dataclass(frozen=True, kw_only=True)
class RequestedEffect:
    """One effect as it is to enter a model.

    `coefficients`: as the diagnosis gives them. `known`: whether these are sizes and not just
    zeros to start from. `Fn`: Froude numbers of the tests; empty where they are those of the
    model. `source`: where the values come from. `moved`: whether the model has an effect of
    derivatives by values of a part of its own.
    """

    effect: Effect
    coefficients: Mapping[str, float]
    known: bool
    value: float | None
    Fn: tuple[float, ...]
    source: str
    moved: bool = False

    @property
    def name(self) -> str:
        """Of the effect."""
        return self.effect.name

    def derivatives(self) -> dict[str, float]:
        """Values of the derivatives from those of the coefficients.

        Coefficients beyond those of captive tests are derivatives themselves.
        """
        beyond = {x: y for x, y in self.coefficients.items() if x not in self.effect.typical}
        return {**self.effect.sizes(self.coefficients), **beyond}


def reference(model: Model, asked: RequestedEffect) -> float:
    """Froude number at which F is zero: the middle of the tests, as in the diagnosis."""
    return float(np.median(_rows(model, asked)))


def _rows(model: Model, asked: RequestedEffect) -> tuple[float, ...]:
    rows = tuple(sorted(set(asked.Fn))) or model.Fn
    if not rows:
        raise ModelError(
            f"{asked.name} changes with the Froude number and model {model.name!r} has none: give "
            f"the Froude numbers of the tests, Fn = (0.15, 0.2, 0.25)."
        )
    return rows


def with_terms(model: Model, asked: RequestedEffect) -> Model:
    """The model with the derivatives of an effect that it lacks, in its convention."""
    sizes = asked.derivatives()
    roll = [label for label in sizes if needs_roll(label.removesuffix(BY_SPEED))]
    if roll and not model.rolls:
        raise ModelError(
            Problem(
                message=f"{asked.name} ({', '.join(roll)}) needs roll, and model {model.name!r} "
                f"has no part 'roll'.",
                remedy=Remedy(
                    "Take a ship that rolls, as {} does, or give it roll by {}.",
                    (
                        Way('to_model(table, parts="s175")', "pmmkit reduce … --parts s175"),
                        Way(
                            "identification.with_roll(model, records)",
                            "pmmkit add MODEL roll --fit RECORDS",
                        ),
                    ),
                ),
            )
        )
    by_speed = {
        label.removesuffix(BY_SPEED): size
        for label, size in sizes.items()
        if label.endswith(BY_SPEED)
    }
    plain = {label: size for label, size in sizes.items() if not label.endswith(BY_SPEED)}
    old = model
    if by_speed:
        model = _changing(model, asked, by_speed)
    there = {label for label in plain if label in _home(model, label).values}
    lacking = {label: size for label, size in plain.items() if label not in there}
    if plain and not lacking:
        raise ModelError(
            f"Model {model.name!r} has {', '.join(plain)} of {asked.name} already: change their "
            f"values, or take them out first (without_effect)."
        )
    values: dict[str, Value] = dict(lacking)
    if asked.known:
        carried = _carried(model, lacking, model.Fn or None)
        values = {name: _plain(x + _apart(model, name)) for name, x in carried.items()}
    made = replace(model, parts=_parts(model, values, asked.source))
    changes: dict[str, Value] = {f"{name}{BY_SPEED}": x for name, x in by_speed.items()}
    systems = [*(["prime"] if changes else []), *([model.convention.system] if values else [])]
    return made.stepped(
        Step(
            action="effect_added",
            effect=asked.name,
            coefficients=MappingProxyType(changes | values),
            system=" and ".join(dict.fromkeys(systems)),
            Fn=asked.Fn,
            left_out=tuple(sorted(there)),
            source=asked.source,
            before=old.before(made),
        )
    )


def _home(model: Model, name: str) -> Part:
    return model.part(model.home_of(name), "an effect of derivatives")


def _parts(model: Model, values: Mapping[str, Value], source: str) -> Mapping[str, Part]:
    """Parts with more derivatives, or with others than before."""
    parts = dict(model.parts)
    for name, value in values.items():
        part = parts[home := _home(model, name).effect]
        before = f"{part.source_of(name)}; " if name in part.values else ""
        parts[home] = replace(
            part,
            values=MappingProxyType({**part.values, name: value}),
            sources=MappingProxyType({**part.sources, name: before + source}),
        )
    return MappingProxyType(parts)


def _changing(model: Model, asked: RequestedEffect, slopes: Mapping[str, float]) -> Model:
    """Derivatives with a value per Froude number: c F more."""
    rows = model.Fn or _rows(model, asked)
    if len(set(rows)) < 2:
        raise ModelError(f"{asked.name} needs two Froude numbers or more, not {list(rows)}.")
    held = {name: _home(model, name).values.get(name, 0.0) for name in slopes}
    if all(isinstance(x, tuple) and np.ptp(x) > 0 for x in held.values()):
        raise ModelError(
            f"{', '.join(held)} of model {model.name!r} change with the Froude number already."
        )
    more = {name: size * _law(model, asked, rows) for name, size in slopes.items()}
    carried = _carried(model, more, rows) if asked.known else more
    values: dict[str, Value] = {
        name: tuple((np.broadcast_to(held[name], len(rows)) + x).tolist())
        for name, x in carried.items()
    }
    covariance = model.covariance
    if not model.Fn and covariance is not None:
        covariance = np.kron(np.ones((len(rows), len(rows))), covariance).astype(float)
    parts = _parts(model, values, asked.source)
    return replace(model, Fn=rows, covariance=covariance, parts=parts)


def _law(model: Model, asked: RequestedEffect, rows: Sequence[float]) -> Array:
    """F = (Fn/Fn0)² - 1 at the Froude numbers of the model."""
    return (np.asarray(rows) / reference(model, asked)) ** 2 - 1.0


def _carried(
    model: Model, sizes: Mapping[str, float | Array], rows: Sequence[float] | None
) -> dict[str, Array]:
    """Derivatives of the diagnosis in the system and signs of a model, one per Froude number."""
    if not sizes:
        return {}
    target = model.convention
    surges = any(parse_derivative(name).count("u") for name in sizes)
    table = from_values(
        {
            name: np.ravel(size).tolist() if np.ndim(size) else float(size)
            for name, size in sizes.items()
        },
        ship=model.ship,
        water=model.water,
        Fn=rows,
        convention=Convention() if surges else Convention(surge=target.surge),
    )
    same = converted(table, target.with_(coriolis="in-derivatives"))
    return {name: same[name] for name in sizes}


def _apart(model: Model, name: str) -> Array | float:
    """What a derivative gains where the Coriolis terms of the added mass stand apart."""
    if model.convention.coriolis == "in-derivatives" or name not in ("Yr", "Xvr"):
        return 0.0
    added = model.part(INERTIA, "a derivative with Coriolis terms").values
    mx, my = (-np.asarray(added.get(item, 0.0)) for item in ("Xudot", "Yvdot"))
    return mx if name == "Yr" else -my


def _plain(column: Array) -> Value:
    """One number where all Froude numbers have the same."""
    numbers: list[float] = np.ravel(column).tolist()
    return numbers[0] if len(set(numbers)) == 1 else tuple(numbers)


def without_terms(model: Model, asked: RequestedEffect) -> Model:
    """The model without the derivatives of an effect, or without their change with speed."""
    sizes = asked.derivatives()
    slopes = [label.removesuffix(BY_SPEED) for label in sizes if label.endswith(BY_SPEED)]
    gone = [x for x in sizes if not x.endswith(BY_SPEED) and x in _home(model, x).values]
    changing = [x for x in slopes if isinstance(_home(model, x).values.get(x), tuple)]
    if not gone and not changing:
        raise ModelError(f"Model {model.name!r} has nothing of {asked.name}.")
    made = model.without_values([f"{_home(model, name).effect}.{name}" for name in gone])
    if not changing:
        return made
    F = _law(made, asked, made.Fn)
    design = np.stack([np.ones_like(F), F], axis=1)
    for name in changing:
        series = np.asarray(_home(made, name).values[name])
        slope = np.linalg.lstsq(design, series, rcond=None)[0][1]
        left = series - slope * F
        home = _home(made, name)
        if np.abs(left).max() < 1e-12 * np.abs(series).max():
            made = made.without_values([f"{home.effect}.{name}"])
        else:
            made = made.with_values(home.effect, **{name: tuple(left.tolist())})
    return made
