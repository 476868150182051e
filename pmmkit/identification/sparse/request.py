"""What is asked of a sparse regression, checked, and its equations sorted for the fit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import DataError, UnknownNameError
from pmmkit.conventions import Structure, parse_derivative
from pmmkit.identification.forces import ForceRecord
from pmmkit.identification.sparse.collinear import Collinearity
from pmmkit.identification.sparse.rows import RunRows, check_records, equations, measured
from pmmkit.inference import Equations, Resampling, SelectionMethod, SparseProblem
from pmmkit.models import Model

Groups = Literal["physics"] | Mapping[str, Sequence[str]] | Sequence[Sequence[str]]
HEEL: Final = frozenset({"phi", "p"})
"""Motions of a run that heels."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SparseRequest:
    """A request after its checks, with the equations of the runs.

    `names`: terms that are looked for, the columns of the equations. `groups`: groups of
    several terms. `channels`: channels of the terms. `fixed`: derivatives held on request.
    `rows`: equations, run by run. `problems`: what is solved together. `runs`: by problem and
    run. `undetermined, unmeasured`: terms that no run excites; terms of channels without
    forces. `collinearity`: terms that move together.
    """

    names: tuple[str, ...]
    groups: Mapping[str, tuple[str, ...]]
    channels: tuple[str, ...]
    fixed: frozenset[str]
    rows: tuple[RunRows, ...]
    problems: tuple[SparseProblem, ...]
    runs: tuple[tuple[Equations, ...], ...]
    undetermined: tuple[str, ...]
    unmeasured: tuple[str, ...]
    collinearity: Collinearity

    def exciting(self) -> NDArray[np.int64]:
        """How many runs excite each term, array (m,)."""
        found = np.zeros(len(self.names), dtype=np.int64)
        for problem, runs in zip(self.problems, self.runs, strict=True):
            usual = Equations.joined(runs).rms()
            found[list(problem.columns)] = sum(run.excited(usual).astype(np.int64) for run in runs)
        return found


def physics_groups(names: Sequence[str]) -> dict[str, tuple[str, ...]]:
    """Groups by physics: lift, drag by moduli, cubic cross-flow, heel, rudder, added mass, surge.

    Examples
    --------
    >>> physics_groups(["Yv", "Nv", "Yv|v|", "Nv|v|", "Yr|r|", "Nvvr"])
    {'lift': ('Yv', 'Nv'), 'drag': ('Yv|v|', 'Nv|v|', 'Yr|r|'), 'cubic': ('Nvvr',)}
    """
    found: dict[str, tuple[str, ...]] = {}
    for name in (parse_derivative(name).name for name in names):
        family = _family(name)
        found[family] = (*found.get(family, ()), name)
    return found


def _family(name: str) -> str:
    derivative = parse_derivative(name)
    factors = derivative.factors
    if derivative.channel == "X":
        return f"surge {derivative.term}"
    if any(factor.endswith("dot") for factor in factors):
        return "added mass"
    for kind, marks in (("rudder", {"d", "|d|"}), ("roll", {"p", "|p|", "phi"})):
        if marks & set(factors):
            return kind
    if any("|" in factor for factor in factors):
        return "drag"
    return {0: "offset", 1: "lift", 2: "even", 3: "cubic"}.get(len(factors), "higher order")


def check_numbers(bags: int, share: float, threshold: float | None, weak: bool | int) -> None:
    """Refuse numbers that make no sense, all at once."""
    wrong = []
    if bags < 2:
        wrong.append(f"bags = {bags}: take at least 2, better 100.")
    if not 0 < share <= 1:
        wrong.append(f"share = {share}: it is a part of the bags, above 0 and up to 1.")
    if threshold is not None and not (np.isfinite(threshold) and threshold >= 0):
        wrong.append(f"threshold = {threshold}: it must not be negative.")
    if weak is not False and weak < 1:
        wrong.append(f"weak = {weak}: a test function has at least one sample.")
    if wrong:
        raise DataError(wrong, title="Sparse regression")


def request(
    model: Model,
    records: Sequence[ForceRecord],
    library: str | Sequence[str] | Structure,
    *,
    fixed: Sequence[str] = (),
    always: Sequence[str] = (),
    groups: Groups | None = None,
    method: SelectionMethod = "stlsq",
    weak: bool | int = False,
    extrapolate: bool = False,
) -> SparseRequest:
    """Check what is asked for and set up the equations; arguments as of `sparse_regression`."""
    if len(records) < Resampling.FEWEST:
        raise DataError(
            f"{len(records)} records are too few to hold runs out and to draw bags of runs: give "
            f"at least {Resampling.FEWEST}, or cut long runs into pieces that are not alike."
        )
    check_records(records)
    held = {parse_derivative(name).name for name in fixed}
    absent = sorted(held - set(model.derivatives))
    if absent:
        raise UnknownNameError(
            f"Model {model.name!r} has no value of {', '.join(absent)} to hold: give it one, or "
            f"leave the name out of fixed."
        )
    listed = [name for name in Structure.meant_by(library).derivatives if name not in held]
    there = {channel for record in records for channel in measured(record)}
    names = [name for name in listed if name[0] in there]
    if not names:
        raise DataError(
            f"Nothing to look for: the library has {', '.join(listed) or 'no free terms'}, the "
            f"records have finite forces with a standard deviation in "
            f"{', '.join(sorted(there)) or 'no channel'}."
        )
    heeled = [name for name in names if parse_derivative(name).heels]
    if heeled and not model.rolls and not any(HEEL & set(item.motion) for item in records):
        raise DataError(
            f"{', '.join(heeled)} need roll: model {model.name!r} has none and no record holds a "
            f"heel (phi, p). Leave these terms out of the library."
        )
    channels = tuple(dict.fromkeys(name[0] for name in names))
    rows = equations(model, records, names, channels, weak=weak, extrapolate=extrapolate)
    seen = excited(rows, names)
    unseen = tuple(name for name in names if name not in seen)
    if not seen:
        raise DataError(
            f"No run excites {', '.join(unseen)}: check that the records hold the motions (v, r, "
            f"udot …) that the terms need."
        )
    wanted = _named_groups(groups, listed, seen)
    kept = _listed(always, listed, "always")
    columns = [names.index(name) for name in seen]
    rows = [_chosen(item, columns) for item in rows]
    problems = _problems(rows, seen, wanted, kept, channels, method)
    runs = tuple(_equations(rows, problem) for problem in problems)
    reports = []
    for problem, each in zip(problems, runs, strict=True):
        whole = Equations.joined(each)
        own = [seen[column] for column in problem.columns]
        _refuse_dependent(whole.dependent(), own)
        reports.append(Collinearity.of(whole, own, problem.channels))
    return SparseRequest(
        fixed=frozenset(held),
        names=tuple(seen),
        groups=wanted,
        channels=channels,
        rows=tuple(rows),
        problems=problems,
        runs=runs,
        undetermined=unseen,
        unmeasured=tuple(name for name in listed if name not in names),
        collinearity=Collinearity.joined(reports),
    )


def excited(rows: Sequence[RunRows], names: Sequence[str]) -> list[str]:
    """Terms of which a derivative of one would stand out of the noise of all runs together."""
    size = np.zeros(len(names))
    for item in rows:
        for design, _ in item.channels.values():
            size += np.sum(design**2, axis=0)
    return [name for name, squares in zip(names, size, strict=True) if squares > 1.0]


def _listed(names: Sequence[str], library: Sequence[str], word: str) -> tuple[str, ...]:
    """Canonical names, all of them in the library."""
    wanted = tuple(parse_derivative(name).name for name in names)
    lost = [name for name in wanted if name not in library]
    if lost:
        raise UnknownNameError(
            f"{', '.join(lost)} of {word} is not in the library, which has {', '.join(library)}. "
            f"Add it to the library, and do not hold it as fixed."
        )
    return wanted


def _named_groups(
    groups: Groups | None, library: Sequence[str], names: Sequence[str]
) -> dict[str, tuple[str, ...]]:
    """Groups by name, of the terms that are looked for; those of one term are left out."""
    if groups is None:
        return {}
    if isinstance(groups, str):
        if groups != "physics":
            raise UnknownNameError(f"groups = {groups!r} is not known: physics, or lists of terms.")
        groups = physics_groups(names)
    if not isinstance(groups, Mapping):
        groups = {" + ".join(group): group for group in groups}
    made = {key: _listed(group, library, "groups") for key, group in groups.items()}
    every = [name for group in made.values() for name in group]
    twice = sorted({name for name in every if every.count(name) > 1})
    if twice:
        raise DataError(f"{', '.join(twice)} stands in two groups: a term belongs to one.")
    own = {key: tuple(name for name in group if name in names) for key, group in made.items()}
    return {key: group for key, group in own.items() if len(group) > 1}


def _chosen(item: RunRows, columns: Sequence[int]) -> RunRows:
    """Equations with some of the columns."""
    own = {
        channel: (design[:, list(columns)], target)
        for channel, (design, target) in item.channels.items()
    }
    return replace(item, channels=MappingProxyType(own))


def _problems(
    rows: Sequence[RunRows],
    names: Sequence[str],
    groups: Mapping[str, Sequence[str]],
    always: Sequence[str],
    channels: Sequence[str],
    method: SelectionMethod,
) -> tuple[SparseProblem, ...]:
    """Channels sorted into systems that share neither a term nor a group."""
    touched = {name: {name[0]} for name in names}
    for item in rows:
        for channel, (design, _) in item.channels.items():
            for place in np.flatnonzero(design.any(axis=0)).tolist():
                touched[names[place]].add(channel)
    single = [(name,) for name in names if all(name not in group for group in groups.values())]
    listed = [*groups.values(), *single]
    ties = [{channel for name in group for channel in touched[name]} for group in listed]
    parts: list[set[str]] = []
    for tie in ties:
        apart = [part for part in parts if not part & tie]
        parts = [*apart, set(tie).union(*(part for part in parts if part & tie))]
    problems = []
    for part in sorted(parts, key=lambda part: min(channels.index(x) for x in part)):
        columns = tuple(place for place, name in enumerate(names) if name[0] in part)
        own = [group for group in listed if group[0][0] in part]
        at = {names[column]: place for place, column in enumerate(columns)}
        problems.append(
            SparseProblem(
                channels=tuple(channel for channel in channels if channel in part),
                columns=columns,
                groups=tuple(tuple(at[name] for name in group) for group in own),
                always=tuple(any(name in always for name in group) for group in own),
                method=method,
            )
        )
    if method not in ("stlsq", "stepwise") and (always or groups):
        raise DataError(
            "Elimination or an optimizer of pysindy knows neither groups nor terms that always "
            "stay: take method 'stlsq' or 'stepwise' with them."
        )
    return tuple(problems)


def _equations(rows: Sequence[RunRows], problem: SparseProblem) -> tuple[Equations, ...]:
    """The equations of a problem, run by run; none of a channel that a run has not measured."""
    columns = list(problem.columns)
    none = (np.empty((0, len(columns))), np.empty(0))
    found = []
    for item in rows:
        parts = []
        for channel in problem.channels:
            X, y = item.channels.get(channel, (np.empty((0, 0)), np.empty(0)))
            parts.append((X[:, columns], y) if len(y) else none)
        found.append(Equations.of(*parts))
    return tuple(found)


def _refuse_dependent(dependent: NDArray[np.bool_], names: Sequence[str]) -> None:
    """Refuse terms of which a mixture gives no force in any run."""
    tied = [name for name, lost in zip(names, dependent, strict=True) if lost]
    if tied:
        raise DataError(
            f"These records cannot tell {', '.join(tied)} apart: some mixture of them gives no "
            f"force in any run. Take one out of the library, hold it as fixed, or add runs of "
            f"other amplitudes and combinations of motions."
        )
