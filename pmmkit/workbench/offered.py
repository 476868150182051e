"""What a page needs of the actions; whoever opens it gives them, the page knows none by itself."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Protocol


class SettingField(Protocol):
    """A setting of an action, as a form asks it."""

    @property
    def name(self) -> str:
        """In a request."""

    @property
    def group(self) -> str:
        """What it belongs to."""

    def allows(self, value: Any) -> bool:
        """Whether something is a value of it."""

    def to_dict(self) -> dict[str, Any]:
        """For the page."""


class Offered(Protocol):
    """An action, as a page offers it."""

    @property
    def fields(self) -> Sequence[SettingField]:
        """Its settings."""

    def default(self, name: str) -> Any:
        """What a setting is if absent."""

    def typed(self, **values: Any) -> str:
        """Its command line."""


Actions = Callable[[str], Offered]
"""The actions by their names."""
