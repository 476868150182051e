"""Which structure to fit where nobody says: the largest that the runs determine."""

from __future__ import annotations

from collections.abc import Callable, Collection
from functools import reduce

import numpy as np

from pmmkit.base import CampaignError
from pmmkit.conventions import CHANNELS, STRUCTURES, Structure, parse_derivative
from pmmkit.presentation import counted, listed
from pmmkit.reduction.derivatives import DerivativeNames
from pmmkit.reduction.solve import Solution


def candidates(measured: Collection[str]) -> tuple[Structure, ...]:
    """Structures in the prime system and u itself, largest first; with heel if K is measured.

    Examples
    --------
    >>> [each.name for each in candidates("XYN")]
    ['abkowitz3', 'modulus', 'cubic', 'linear']
    """
    plain = [
        each
        for each in STRUCTURES.values()
        if (each.system, each.surge) == ("prime", "u") and ("K" in measured or not each.of("K"))
    ]
    return tuple(sorted(plain, key=lambda each: -len(each.derivatives)))


def all_terms() -> Structure:
    """The terms of all candidates together, for reading the runs once."""
    first, *others = candidates(CHANNELS)
    return reduce(lambda found, each: found.with_(*each.derivatives), others, first)


def largest_determined(
    measured: Collection[str],
    columns: Callable[[Structure], DerivativeNames],
    fit: Callable[[DerivativeNames], Solution],
) -> tuple[Structure, str]:
    """The largest structure of which the runs determine every term, and what speaks for it; where
    there is none, the largest of which they determine some.

    Notes
    -----
    The Froude number with the most runs is asked. A term that no run excites, or that others
    make up entirely, has no value there. Terms of X do not decide: the commonest programme, drift,
    sway and yaw alone, leaves Xvr open, and a model takes it from an estimate. Neither do
    accelerations, which no rotating arm shows, nor the roll rate, since few laboratories force a
    model to roll: a model takes added mass and roll damping from estimates too.
    """
    lacking: dict[str, list[str]] = {}
    best: tuple[float, Structure] | None = None
    part: Structure | None = None
    for structure in candidates(measured):
        if best and len(structure.derivatives) < len(best[1].derivatives):
            break
        asked = columns(structure)
        solution = fit(asked)
        judged, valued = _judged(asked), _valued(solution)
        if judged - valued:
            lacking[structure.name] = sorted(judged - valued)
            part = part or (structure if judged & valued else None)
        elif best is None or _left(solution) < best[0]:
            best = (_left(solution), structure)
    if best is not None:
        return best[1], _because(best[1], lacking)
    if part is None:
        raise CampaignError("These runs show no derivative of side force and moment.")
    return part, (
        f"Structure {part.name}: no structure is determined by these runs; of this one they do not "
        f"show {listed(lacking[part.name])}."
    )


def _judged(columns: DerivativeNames) -> set[str]:
    """The terms that decide: of all channels but X, where there are others; see the notes above."""
    sideways = {
        name
        for names in columns.required.values()
        for name in names
        if name[0] != "X"
        and not any(it == "p" or it.endswith("dot") for it in parse_derivative(name).factors)
    }
    return sideways or {name for names in columns.required.values() for name in names}


def _valued(solution: Solution) -> set[str]:
    """Derivatives that have a value at the Froude number with the most runs."""
    largest = int(np.argmax([len(members) for members in solution.groups]))
    return {
        name
        for (group, name), value in zip(solution.joint.labels, solution.joint.value, strict=True)
        if group == largest and np.isfinite(value)
    }


def _left(solution: Solution) -> float:
    """What the fits leave of the forces, the geometric mean over channels."""
    return float(np.mean([np.log(max(item.left, 1e-12)) for _, item in solution.fits]))


def _because(structure: Structure, lacking: dict[str, list[str]]) -> str:
    told = [
        f"{name} has {counted(len(names), 'term')} that they do not show ({listed(names)})"
        for name, names in lacking.items()
    ]
    return (
        f"Structure {structure.name}: the largest of which these runs determine every term"
        " of side force and moment" + (f"; {'; '.join(told)}" if told else "") + "."
    )
