"""The campaigns that are open, read while their files stay as they are, and compared."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from functools import partial
from pathlib import Path
from threading import Lock
from typing import Any, Final

from pmmkit.base import DataError
from pmmkit.campaigns import Campaign, open_campaign
from pmmkit.models import load_model
from pmmkit.validation import Comparison, compare, observed
from pmmkit.workbench.saved import WorkbenchState, model_file, stamp_of

# What a server has worked out, kept to be asked for again.


KEPT: Final = 16
"""Answers that are kept, the last that were asked for: undo and add go back and forth."""


class AnswerCache:
    """Answers by what they are about: whoever asks while one is made waits for that one alone."""

    def __init__(self) -> None:
        self._changing = Lock()
        self._known: dict[tuple[Any, ...], Future[Any]] = {}

    def clear(self) -> None:
        """Forget all."""
        with self._changing:
            self._known.clear()

    def once(self, key: tuple[Any, ...], work: Callable[[], Any]) -> Any:
        """What was worked out before, or is now; an error is told, and not kept."""
        made: Future[Any] = Future()
        with self._changing:
            found = self._known.pop(key, made)
            self._known[key] = found
            while len(self._known) > KEPT:
                del self._known[next(iter(self._known))]
        if found is made:
            try:
                made.set_result(work())
            except BaseException as error:
                with self._changing:
                    if self._known.get(key) is made:
                        del self._known[key]
                made.set_exception(error)
        return found.result()


class OpenCampaigns:
    """The campaigns of a workbench; `of` is the place of one among them.

    `folder`: of the workbench, where its models lie. `named`: a path of the state inside the
    folders that were named. `known`: where answers are kept; all go when a file has changed.
    """

    def __init__(self, folder: Path, named: Callable[[str], Path], known: AnswerCache) -> None:
        self._folder, self._named, self._known = folder, named, known
        self._stamps: dict[Path, tuple[int, int]] = {}

    def campaign(self, state: WorkbenchState, of: int = 0) -> Campaign:
        """The tests as they are."""
        place = self.place(state, of)
        stamp = self.stamp(state, of)
        if self._stamps.get(place, stamp) != stamp:
            self._known.clear()
        self._stamps[place] = stamp
        found: Campaign = self._known.once(
            ("campaign", str(place), state.data),
            lambda: open_campaign(place, data=state.data or None),
        )
        return found

    def place(self, state: WorkbenchState, of: int = 0) -> Path:
        """Where the tests lie."""
        if of >= len(state.campaigns):
            raise DataError(f"There is no campaign {of + 1}: {len(state.campaigns)} are open.")
        return self._named(state.campaigns[of])

    def stamp(self, state: WorkbenchState, of: int = 0) -> tuple[int, int]:
        """When the campaign file was changed, and its size."""
        return stamp_of(self.place(state, of))

    def every(self, state: WorkbenchState) -> dict[str, Campaign]:
        """All campaigns by their titles."""
        return Campaign.by_title([self.campaign(state, of) for of in range(len(state.campaigns))])

    def sailing(self, state: WorkbenchState) -> Campaign:
        """The tests of the ship: the first that let it sail by itself, else the first."""
        every = self.every(state)
        return max(every.values(), key=lambda item: item.kind == "free-running")

    def comparison(
        self, state: WorkbenchState, effects: tuple[str, ...], of: int = 0
    ) -> Comparison:
        """Tests and the model with some effects, as these tests have it."""
        tests = self.campaign(state, of)
        model = model_file(self._folder, effects, of if state.also else None)

        def work() -> Comparison:
            captive = tests.kind == "captive"
            views = self._known.once(("views", of), partial(observed, tests)) if captive else None
            return compare(load_model(model), tests, views=views)

        found: Comparison = self._known.once(("comparison", effects, of), work)
        return found
