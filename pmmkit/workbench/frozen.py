"""The page of a workbench with its state in one HTML file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from pmmkit.errors import PmmkitError
from pmmkit.workbench.desk import Desk
from pmmkit.workbench.page_file import Answers, fitted, page_file, with_runs, worst_first


def frozen_page(desk: Desk) -> str:
    """The page of a workbench as one file.

    Parameters
    ----------
    desk : Desk
        With something open. What was not asked yet is not in the file.
    """
    return page_file(answers(desk))


def answers(desk: Desk) -> Answers:
    """What the page asks, by the words it asks with."""
    state = desk.page()
    count = len(state.get("steps", ()))
    found: Answers = {"state": {**state, "job": {**state["job"], "stand": "idle"}}}
    for number in range(count + 1):
        found[f"misfit {number}"] = desk.misfit(number)
    asked: Mapping[str, Callable[[], Any]] = {
        "missing": desk.missing,
        "fall": desk.fall,
        "turns": desk.turns,
        "checks": desk.checks,
        "derivatives": desk.derivatives,
        "runs 0": lambda: desk.runs(0),
    }
    for name, give in asked.items():
        try:
            found[name] = give()
        except PmmkitError:
            found[name] = None
    found = fitted(found)
    return with_runs(
        found,
        worst_first(found[f"misfit {count}"]),
        lambda run, buckets: desk.history(run, buckets=buckets),
        count,
    )
