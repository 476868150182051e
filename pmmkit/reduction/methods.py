"""The same derivatives by the classical ways: one family of tests, or one run, at a time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from pmmkit.campaigns.run import Campaign
from pmmkit.conventions import Convention, parse_derivative
from pmmkit.observations.equations import Rows, Sensitivity
from pmmkit.reduction.derivatives import Columns
from pmmkit.reduction.solve import Solution, solve, to_table
from pmmkit.tables import DerivativeTable


@dataclass(frozen=True)
class Family:
    """Tests that are fitted together, and the variables that they excite.

    Parameters
    ----------
    key : str
        The test without which the family is not there.
    tests : tuple of str
        All tests that take part.
    factors : tuple of str
        Variables that may stand in the derivatives.
    """

    key: str
    tests: tuple[str, ...]
    factors: tuple[str, ...]


FAMILIES: Final[Mapping[str, Family]] = {
    "static drift": Family("static_drift", ("static_drift",), ("u", "v", "T")),
    "static rudder": Family("static_rudder", ("static_rudder",), ("u", "d", "T")),
    "drift with rudder": Family(
        "drift_rudder", ("static_drift", "static_rudder", "drift_rudder"), ("u", "v", "d", "T")
    ),
    "static heel": Family("static_heel", ("static_heel",), ("u", "v", "phi", "T")),
    "circular motion": Family("circular_motion", ("circular_motion",), ("u", "v", "r", "T")),
    "pure surge": Family("pure_surge", ("pure_surge",), ("u", "udot", "T")),
    "pure sway": Family("pure_sway", ("pure_sway",), ("u", "v", "vdot", "T")),
    "pure yaw": Family("pure_yaw", ("pure_yaw",), ("u", "r", "udot", "rdot", "T")),
    "yaw with drift": Family("yaw_drift", ("yaw_drift",), ("u", "v", "r", "udot", "rdot", "T")),
}


def by_family(
    rows: Sequence[Rows],
    sensitivities: Sequence[Sequence[Sensitivity]],
    columns: Columns,
    solution: Solution,
    campaign: Campaign,
    convention: Convention,
) -> dict[str, DerivativeTable]:
    """Derivatives from each family of tests alone: curve fits and multiple-run balance.

    Parameters
    ----------
    rows, sensitivities, columns
        As in `solve`.
    solution : Solution
        The global solution; its Froude groups are used.
    campaign, convention
        For the tables.

    Returns
    -------
    dict of str to DerivativeTable
        By the family's name; families without runs are absent.
    """
    tables = {}
    for name, family in FAMILIES.items():
        groups = [
            (float(froude), chosen)
            for froude, members in zip(solution.Fn, solution.groups, strict=True)
            if (chosen := [i for i in members if rows[i].result.run.test in family.tests])
            and any(rows[i].result.run.test == family.key for i in chosen)
        ]
        wanted = columns.only(family.factors)
        if not groups or not any(wanted.required.values()):
            continue
        found = solve(rows, sensitivities, wanted, groups)
        if found.fits:
            tables[name] = to_table(found, wanted, campaign, convention, method=name)
    return tables


def by_run(
    rows: Sequence[Rows],
    sensitivities: Sequence[Sequence[Sensitivity]],
    columns: Columns,
    solution: Solution,
    campaign: Campaign,
    convention: Convention,
) -> dict[str, DerivativeTable]:
    """Single-run derivatives: the harmonic balance of each oscillating run by itself.

    In yaw with drift the single-motion derivatives are held at the global solution, so that the
    run gives the coupling ones.

    Parameters
    ----------
    rows, sensitivities, columns, solution, campaign, convention
        As in `by_family`.

    Returns
    -------
    dict of str to DerivativeTable
        By the run's id.
    """
    values: dict[int, dict[str, float]] = {}
    for group, item in solution.fits:
        values.setdefault(group, {}).update(item.values())
    families = {family.key: family for family in FAMILIES.values()}
    tables = {}
    for group, members in enumerate(solution.groups):
        for place in members:
            run = rows[place].result.run
            if not run.dynamic or run.test not in families:
                continue
            wanted = columns.only(families[run.test].factors, optional=False)
            held: dict[str, float] = {}
            if run.test == "yaw_drift":
                wanted = Columns(
                    required={c: tuple(filter(couples, n)) for c, n in wanted.required.items()},
                    optional=wanted.optional,
                )
                asked = {name for names in wanted.required.values() for name in names}
                held = {k: v for k, v in values.get(group, {}).items() if k not in asked}
            if not any(wanted.required.values()):
                continue
            found = solve(
                rows, sensitivities, wanted, [(float(solution.Fn[group]), [place])], {0: held}
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
