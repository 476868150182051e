"""The same derivatives by the classical ways: one family of tests, or one run, at a time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from pmmkit.campaigns import TEST_KINDS, Campaign
from pmmkit.conventions import STRUCTURES, Convention, Structure, parse_derivative
from pmmkit.models import DerivativeTable
from pmmkit.reduction.derivatives import DerivativeNames
from pmmkit.reduction.observations.equations import Rows, Sensitivity
from pmmkit.reduction.solve import Solution, solve, to_table

# The terms among which a method may choose.


def library_of(
    columns: DerivativeNames, structure: Structure, library: str | Sequence[str] | Structure | None
) -> dict[str, tuple[str, ...]]:
    """Terms by channel: those asked for, then those of the library.

    Examples
    --------
    >>> from pmmkit.conventions import STRUCTURES
    >>> asked = DerivativeNames(required={"Y": ("Yv", "Yvvv")}, optional={"Y": ("Y0",)})
    >>> library_of(asked, Structure.meant_by("Yv Yvvv"), None)["Y"]
    ('Yv', 'Yvvv', 'Y0', 'Yv|v|')
    """
    if library is None:
        known = {factor for name in structure.derivatives for factor in _variables(name)}
        more = [
            name
            for other in STRUCTURES.values()
            if other.surge == structure.surge
            for name in other.derivatives
            if _variables(name) <= known
        ]
    else:
        more = list(Structure.meant_by(library).derivatives)
    return {
        channel: tuple(dict.fromkeys((*own, *(name for name in more if name[0] == channel))))
        for channel, own in columns.names.items()
    }


def _variables(name: str) -> frozenset[str]:
    return parse_derivative(name).variables


def by_family(
    rows: Sequence[Rows],
    sensitivities: Sequence[Sequence[Sensitivity]],
    columns: DerivativeNames,
    solution: Solution,
    campaign: Campaign,
    convention: Convention,
) -> dict[str, DerivativeTable]:
    """Derivatives from each family of tests alone: curve fits and multiple-run balance.

    Their intervals hold the scatter that repeats show: families that contradict each other would
    widen the scatter by which all runs agree.
    """
    tables = {}
    between = replace(solution.between, scatter=solution.repeatability)
    for kind in (x for x in TEST_KINDS.values() if x.captive):
        if kind.fit is None:
            continue
        tests = (kind.name, *kind.fit.beside)
        groups = [
            (float(froude), chosen)
            for froude, members in zip(solution.Fn, solution.groups, strict=True)
            if (chosen := [i for i in members if rows[i].result.run.test in tests])
            and any(rows[i].result.run.test == kind.name for i in chosen)
        ]
        wanted = columns.only(kind.fit.factors)
        if not groups or not any(wanted.required.values()):
            continue
        found = solve(rows, sensitivities, wanted, groups, between)
        if found.fits:
            tables[kind.title] = to_table(found, wanted, campaign, convention, method=kind.title)
    return tables


def by_run(
    rows: Sequence[Rows],
    sensitivities: Sequence[Sequence[Sensitivity]],
    columns: DerivativeNames,
    solution: Solution,
    campaign: Campaign,
    convention: Convention,
) -> dict[str, DerivativeTable]:
    """Single-run derivatives: the harmonic balance of each oscillating run by itself.

    In yaw with drift the single-motion derivatives are held at the global solution, so that the
    run gives the coupling ones.
    """
    values: dict[int, dict[str, float]] = {}
    for group, item in solution.fits:
        values.setdefault(group, {}).update(item.values())
    tables = {}
    for group, members in enumerate(solution.groups):
        for place in members:
            run = rows[place].result.run
            kind = run.kind_of_test
            if not kind.oscillates or kind.fit is None:
                continue
            wanted = columns.only(kind.fit.factors, optional=False)
            held: dict[str, float] = {}
            if {"v", "r"} <= set(kind.fit.factors):
                wanted = DerivativeNames(
                    required={c: tuple(filter(couples, n)) for c, n in wanted.required.items()},
                    optional=wanted.optional,
                )
                asked = {name for names in wanted.required.values() for name in names}
                held = {k: v for k, v in values.get(group, {}).items() if k not in asked}
            if not any(wanted.required.values()):
                continue
            found = solve(
                rows,
                sensitivities,
                wanted,
                [(float(solution.Fn[group]), [place])],
                solution.between,
                {0: held},
            )
            if found.fits:
                tables[run.id] = to_table(found, wanted, campaign, convention, method="single run")
    return tables


def couples(name: str) -> bool:
    """Whether a derivative couples sway and yaw.

    Examples
    --------
    >>> couples("Nvvr"), couples("Nr")
    (True, False)
    """
    derivative = parse_derivative(name)
    return bool(derivative.count("v") and derivative.count("r"))
