"""What a step changed in a model, kept so that the step can be taken back."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmmkit.models.model import Model, Part, place_name
from pmmkit.models.step import Before, Value


def before_of(old: Model, new: Model, places: Collection[str] | None = None) -> Before:
    """What of a model a step changed, as it was.

    Parameters
    ----------
    old, new : Model
        Before and after the step.
    places : collection of str, optional
        Parts and values (``hull_polynomial.Yvvr``) that belong to the step; all by default. What
        a part was told to use its values belongs to them.

    Examples
    --------
    >>> from pmmkit.models.edit import with_effect
    >>> from pmmkit.models.store import load_model
    >>> ship = load_model("s175-3dof")
    >>> before_of(ship, with_effect(ship, "memory")).absent
    ('memory',)
    """
    absent: list[str] = []
    values: dict[str, Value] = {}
    sources: dict[str, str] = {}
    options: dict[str, str] = {}
    touched = None if places is None else {place.partition(".")[0] for place in places}
    for effect, part in new.parts.items():
        if effect not in old.parts and (places is None or effect in places):
            absent.append(effect)
            continue
        was = old.parts.get(effect, Part(effect=effect))
        there = effect in old.parts and (touched is None or effect in touched)
        for name, word in part.options.items() if there else ():
            if name not in was.options:
                absent.append(f"{effect}.{name}")
            elif was.options[name] != word:
                options[f"{effect}.{name}"] = was.options[name]
        for name, value in part.values.items():
            place = f"{effect}.{name}"
            if places is not None and place not in places:
                continue
            if name not in was.values:
                absent.append(place)
            elif was.values[name] != value:
                values[place] = was.values[name]
                if name in was.sources:
                    sources[place] = was.sources[name]
    return Before(
        absent=tuple(absent),
        values=MappingProxyType(values),
        sources=MappingProxyType(sources),
        options=MappingProxyType(options),
        pooled=bool(new.Fn) and not old.Fn,
    )


def restored(model: Model, before: Before) -> Model:
    """A model with what a step changed as it was before.

    Parameters
    ----------
    model : Model
        After the step.
    before : Before
        As `before_of` gives it.

    Examples
    --------
    >>> from pmmkit.models.edit import with_effect
    >>> from pmmkit.models.store import load_model, model_text
    >>> ship = load_model("s175-3dof")
    >>> slow = with_effect(ship, "froude_linear", coefficients="typical", Fn=(0.1, 0.2, 0.3))
    >>> back = restored(slow, slow.steps[-1].before).with_(steps=ship.steps)
    >>> model_text(back) == model_text(ship)
    True
    """
    made = without_values(model, before.absent)
    parts = dict(made.parts)
    for place, value in before.values.items():
        effect, _, name = place.partition(".")
        if effect not in parts:
            continue
        part = parts[effect]
        sources = dict(part.sources)
        if place in before.sources:
            sources[name] = before.sources[place]
        else:
            sources.pop(name, None)
        parts[effect] = replace(
            part,
            values=MappingProxyType({**part.values, name: value}),
            sources=MappingProxyType(sources),
        )
    for place, word in before.options.items():
        effect, _, name = place.partition(".")
        if effect in parts:
            words = MappingProxyType({**parts[effect].options, name: word})
            parts[effect] = replace(parts[effect], options=words)
    made = replace(made, parts=MappingProxyType(parts))
    return _pooled(made) if before.pooled else made


def without_values(model: Model, places: Iterable[str]) -> Model:
    """A model without some parts, or values and options of parts, nor sources and covariance."""
    gone = frozenset(places)
    parts = {
        effect: replace(
            part,
            values=_left(part.values, effect, gone),
            sources=_left(part.sources, effect, gone),
            std=_left(part.std, effect, gone),
            options=_left(part.options, effect, gone),
        )
        for effect, part in model.parts.items()
        if effect not in gone
    }
    there = {place_name(effect, name) for effect, x in parts.items() for name in x.values}
    C, names = covariance_of(model, [name for name in model.covariance_names if name in there])
    return replace(model, parts=MappingProxyType(parts), covariance=C, covariance_names=names)


def covariance_of(
    model: Model, names: Collection[str]
) -> tuple[NDArray[np.float64] | None, tuple[str, ...]]:
    """The covariance of some derivatives of a model at all its Froude numbers, and their names.

    Examples
    --------
    >>> from pmmkit.models.store import load_model
    >>> known = {"covariance": np.diag([1.0, 4.0]), "covariance_names": ("Yv", "Nv")}
    >>> covariance_of(load_model("kvlcc2").with_(**known), ["Nv"])
    (array([[4.]]), ('Nv',))
    """
    kept = [i for i, name in enumerate(model.covariance_names) if name in names]
    if model.covariance is None or not kept:
        return None, ()
    count, rows = len(model.covariance_names), max(len(model.Fn), 1)
    at = [row * count + i for row in range(rows) for i in kept]
    return model.covariance[np.ix_(at, at)], tuple(model.covariance_names[i] for i in kept)


def _left(content: Mapping[str, Any], effect: str, gone: frozenset[str]) -> Mapping[str, Any]:
    return MappingProxyType({k: x for k, x in content.items() if f"{effect}.{k}" not in gone})


def _pooled(model: Model) -> Model:
    """One value for all speeds, as before an effect of the speed; if no other effect has any."""
    over_speed = {
        f"{effect}.{name}": value
        for effect, part in model.parts.items()
        for name, value in part.values.items()
        if isinstance(value, tuple) and name not in part.known.tables
    }
    if any(len(set(value)) > 1 for value in over_speed.values()):
        return model
    parts = {
        effect: replace(
            part,
            values=MappingProxyType(
                {
                    name: over_speed.get(f"{effect}.{name}", (value,))[0]
                    for name, value in part.values.items()
                }
            ),
        )
        for effect, part in model.parts.items()
    }
    m = len(model.covariance_names)
    C = None if model.covariance is None else model.covariance[:m, :m]
    return replace(model, Fn=(), parts=MappingProxyType(parts), covariance=C)
