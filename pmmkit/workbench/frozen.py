"""The page of a workbench with its state in one HTML file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from pmmkit.errors import PmmkitError
from pmmkit.workbench.desk import Desk
from pmmkit.workbench.page_file import page_file
from pmmkit.workbench.page_room import Answers, asked_of, fitted, with_runs, worst_first


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
    campaigns = range(len(state.get("campaigns", ())) or 1)
    for number in range(count + 1):
        for of in campaigns:
            found[asked_of(f"misfit {number}", of)] = desk.misfit(number, of)
    asked: Mapping[str, Callable[[], Any]] = {
        "missing": desk.missing,
        "fall": desk.fall,
        "turns": desk.turns,
        **{asked_of("checks", of): partial(desk.checks, of) for of in campaigns},
        **{asked_of("derivatives", of): partial(desk.derivatives, of) for of in campaigns},
        **{asked_of("runs 0", of): partial(desk.runs, 0, of) for of in campaigns},
    }
    for name, give in asked.items():
        try:
            found[name] = give()
        except PmmkitError:
            found[name] = None
    found = fitted(found)
    for of in campaigns:
        found = with_runs(
            found,
            worst_first(found[asked_of(f"misfit {count}", of)]),
            partial(_history, desk, of),
            partial(_asks_run, count, of),
            share=1.0 / (len(campaigns) - of),
        )
    return found


def _history(desk: Desk, of: int, run: str, buckets: int) -> Any:
    return desk.history(run, buckets=buckets, of=of)


def _asks_run(count: int, of: int, run: str) -> str:
    return asked_of(f"run {run} {count}", of)
