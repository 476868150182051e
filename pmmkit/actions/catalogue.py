"""The actions that there are: a file each in `jobs`, found by their names."""

from __future__ import annotations

import pkgutil
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from typing import Any, Final, get_type_hints

from pmmkit.actions.outcome import Outcome
from pmmkit.actions.setting import JobSetting, as_typed, settings_from, settings_of
from pmmkit.base import UnknownNameError

JOBS: Final = "pmmkit.actions.jobs"
"""Where they lie."""
STAGES: Final = ("begin", "measure", "model", "predict", "explain", "hand in")
"""The stages of the work, in their order."""
_STAGE: Final = re.compile(r'^STAGE: Final = \("(.+)", (\d+)\)$', re.MULTILINE)


@dataclass(frozen=True, kw_only=True)
class Action:
    """Something that pmmkit does when it is asked.

    Parameters
    ----------
    name : str
        As it is typed.
    about : str
        What it does.
    settings : type
        The dataclass of what it is asked.
    do : callable
        Does it with such settings.
    example : str
        A command line.
    """

    name: str
    about: str
    settings: type
    do: Callable[[Any], Outcome]
    example: str

    @property
    def fields(self) -> tuple[JobSetting, ...]:
        """Its settings."""
        return settings_of(self.settings)

    def default(self, name: str) -> Any:
        """What a setting is if absent."""
        (value,) = (item.default for item in self.fields if item.name == name)
        return value

    def typed(self, **values: Any) -> str:
        """The command line of settings by their names; None stands for one that is absent.

        Examples
        --------
        >>> action("scale").typed(model="kvlcc2-l7", length=320.0, speed=None)
        'pmmkit scale kvlcc2-l7 --length 320'
        """
        given = {name: value for name, value in values.items() if value is not None}
        return f"pmmkit {self.name} {as_typed(self.asked(given))}".rstrip()

    def asked(self, values: Mapping[str, Any]) -> Any:
        """Its settings with values by their names."""
        return settings_from(self.settings, values)


@cache
def names() -> tuple[str, ...]:
    """Names of all actions, as they are typed."""
    found = pkgutil.iter_modules(import_module(JOBS).__path__)
    return tuple(module.name.replace("_", "-") for module in found)


def about(name: str) -> str:
    """What the action of a `name` does. Its file is read, not loaded: a list of all takes no time.

    Examples
    --------
    >>> about("ships")
    'Show the library of ships.'
    """
    return _text(name).split('"""', 2)[1]


def by_stage() -> dict[str, tuple[str, ...]]:
    """Names of all actions by the stage of the work that each serves, in its order there.

    Examples
    --------
    >>> by_stage()["predict"]
    ('simulate', 'sweep', 'stability', 'uncertainty', 'seakeeping')
    """
    places = {name: _STAGE.findall(_text(name))[0] for name in names()}
    ordered = sorted(places, key=lambda name: int(places[name][1]))
    return {stage: tuple(name for name in ordered if places[name][0] == stage) for stage in STAGES}


@cache
def _text(name: str) -> str:
    """The file of an action, which is not loaded."""
    return (pkgutil.get_data(JOBS, f"{_module(name)}.py") or b"").decode()


def _module(name: str) -> str:
    return name.replace("-", "_")


@cache
def action(name: str) -> Action:
    """The action of a name.

    Raises
    ------
    UnknownNameError
        If there is none.

    Examples
    --------
    >>> scale = action("scale")
    >>> scale.example
    'pmmkit scale kvlcc2-l7 --length 320 --speed 8'
    >>> [field.name for field in scale.fields][:3]
    ['model', 'length', 'like']
    """
    if name not in names():
        raise UnknownNameError(f"There is no command {name!r}.")
    own = _module(name)
    module = import_module(f"{JOBS}.{own}")
    do = getattr(module, own)
    (settings,) = (kind for name, kind in get_type_hints(do).items() if name != "return")
    return Action(name=name, about=about(name), settings=settings, do=do, example=module.EXAMPLE)
