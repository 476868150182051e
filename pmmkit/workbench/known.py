"""What a server has worked out, kept to be asked for again."""

from __future__ import annotations

from collections.abc import Callable
from threading import RLock
from typing import Any, Final

KEPT: Final = 16
"""Answers that are kept, the last that were asked for: undo and add go back and forth."""


class AnswerCache:
    """Answers by what they are about, made one at a time so that nothing is done twice."""

    def __init__(self) -> None:
        self._working = RLock()
        self._known: dict[tuple[Any, ...], Any] = {}

    def clear(self) -> None:
        """Forget all."""
        with self._working:
            self._known.clear()

    def once(self, key: tuple[Any, ...], work: Callable[[], Any]) -> Any:
        """What was worked out before, or is now."""
        with self._working:
            found = self._known.pop(key) if key in self._known else work()
            while len(self._known) >= KEPT:
                del self._known[next(iter(self._known))]
            self._known[key] = found
            return found

    def aside(self, key: tuple[Any, ...], work: Callable[[], Any]) -> Any:
        """The same for what may take a minute: meanwhile everything else is answered."""
        with self._working:
            if key in self._known:
                return self._known[key]
        found = work()
        return self.once(key, lambda: found)
