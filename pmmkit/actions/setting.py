"""What a job is asked: dataclasses of settings, of which options, forms and pages are made.

A setting of one job is a field made by `setting`; one that several jobs have is a type with `Help`
beside it. A field whose type is such a dataclass is a group of settings, headed by what that says
of itself. Names are those of the fields throughout:
``wave_height`` in Python and in a request, ``--wave-height`` as it is typed.
"""

from __future__ import annotations

import inspect
import math
import shlex
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import MISSING, dataclass, field, fields, replace
from pathlib import Path
from types import NoneType, UnionType
from typing import (
    Annotated,
    Any,
    Literal,
    TypeVar,
    Union,
    dataclass_transform,
    get_args,
    get_origin,
    get_type_hints,
)

from pmmkit.base import DataError
from pmmkit.presentation import quoted

Settings = TypeVar("Settings")
"""A dataclass of settings."""


class SettingError(DataError):
    """A setting cannot be read, or contradicts another one.

    Parameters
    ----------
    problem : str
        What is wrong, and what to write instead.
    option : str
        The option that is meant, where it is one that was left out.
    """

    def __init__(self, problem: str, option: str = "") -> None:
        super().__init__(problem)
        self.option = option


@dataclass(frozen=True)
class Help:
    """What is told of a setting, and how it is typed.

    `text`: what it is, in a sentence. `names`: as it is typed, where that is not the name of
    its field: ``--for``, ``-o --output``. `argument`: whether its value stands without a name.
    `usual`: from where to where a slider goes, and its step. `unit`: in which a form shows it.
    `read`: makes its value of a text. `metavar`: what stands for the value in a synopsis.
    """

    text: str
    names: str = ""
    argument: bool = False
    least: float | None = None
    most: float | None = None
    usual: tuple[float, float, float] | None = None
    unit: str = ""
    read: Callable[[str], Any] | None = None
    metavar: str | None = None


def setting(text: str, *, default: Any = MISSING, **told: Any) -> Any:
    """A field that is a setting of one job: its default, and what `Help` takes."""
    return field(default=default, metadata={Help: Help(text, **told)})


@dataclass_transform(kw_only_default=True, frozen_default=True, field_specifiers=(setting,))
def settings(declared: type[Settings]) -> type[Settings]:
    """Make a frozen dataclass of settings."""
    return dataclass(frozen=True, kw_only=True)(declared)


@dataclass(frozen=True, kw_only=True)
class JobSetting:
    """A setting of a job, as its dataclass declares it.

    Parameters
    ----------
    name : str
        Of the field.
    type : type
        Of its value.
    default : object
        The value if absent; `dataclasses.MISSING` where it must be stated.
    help : Help
        What is told of it.
    group : str
        Field of the group that it belongs to; empty where it is the job's own.
    heading : str
        What that group is.
    """

    name: str
    type: Any
    default: Any
    help: Help
    group: str = ""
    heading: str = ""

    @property
    def required(self) -> bool:
        """Whether it must be stated."""
        return self.default is MISSING

    @property
    def several(self) -> bool:
        """Whether it takes any number of values."""
        return get_origin(self.type) is tuple

    @property
    def bare(self) -> Any:
        """The type of one value, None apart."""
        if self.several:
            return get_args(self.type)[0]
        if get_origin(self.type) in (Union, UnionType):
            (own,) = (item for item in get_args(self.type) if item is not NoneType)
            return own
        return self.type

    @property
    def choices(self) -> tuple[Any, ...]:
        """All values that there are; none where there is no list of them."""
        return get_args(self.bare) if get_origin(self.bare) is Literal else ()

    @property
    def form(self) -> str:
        """How it is asked in a form: a choice, switch, number, whole number or text."""
        if self.choices:
            return "choice"
        known = {bool: "switch", int: "whole", float: "number"}
        return known.get(self.bare, "number" if self.help.read else "text")

    @property
    def options(self) -> tuple[str, ...]:
        """Its names as they are typed; none of an argument."""
        if self.help.argument:
            return ()
        plain = f"--{self.name.replace('_', '-')}"
        if self.help.names:
            return tuple(self.help.names.split())
        return (f"{plain}/--no-{plain[2:]}",) if self.default is True else (plain,)

    @property
    def option(self) -> str:
        """Its first name; nothing of an argument."""
        return next(iter(self.options), "")

    def typed(self, value: Any) -> list[str]:
        """A value as it is typed, with its option; nothing where it is what is there if absent."""
        option = self.option
        if value == self.default:
            return []
        if self.bare is bool:
            return [option.split("/")[not value] if self.default else option]
        return [f"{option} {_word(one)}".strip() for one in (value if self.several else [value])]

    def allows(self, value: Any) -> bool:
        """Whether something that came from a form is a value of it, within its limits."""
        if self.choices:
            return value in self.choices
        if isinstance(value, bool) or self.form == "switch":
            return isinstance(value, bool) and self.form == "switch"
        if self.form == "text":
            return isinstance(value, str)
        least, most = self.help.least, self.help.most
        return (
            isinstance(value, int if self.form == "whole" else int | float)
            and (least is None or value >= least)
            and (most is None or value <= most)
        )

    def to_dict(self) -> dict[str, Any]:
        """As a form reads it."""
        return {
            "name": self.name,
            "option": self.option,
            "help": self.help.text,
            "heading": self.heading,
            "type": self.form,
            "choices": list(self.choices),
            "several": self.several,
            "required": self.required,
            "default": None if self.required else self.default,
            "least": self.help.least,
            "most": self.help.most,
            "usual": self.help.usual,
            "unit": self.help.unit,
        }


def settings_of(declared: type) -> tuple[JobSetting, ...]:
    """The settings that a dataclass, `declared`, has; those of a group where the group stands.

    Examples
    --------
    >>> from pmmkit.actions.jobs.compare import CompareSettings
    >>> floor, height = (settings_of(CompareSettings)[place] for place in (2, 5))
    >>> floor.options, floor.default, floor.help.most
    (('--floor',), 0.005, 0.5)
    >>> height.options, height.group, height.heading
    (('--wave-height',), 'waves', 'Waves')
    """
    hints = get_type_hints(declared, include_extras=True)
    found: list[JobSetting] = []
    for own in fields(declared):
        kind = hints[own.name]
        told = own.metadata.get(Help)
        if get_origin(kind) is Annotated:
            kind, told = get_args(kind)
        if told is not None:
            found.append(JobSetting(name=own.name, type=kind, default=own.default, help=told))
        else:
            heading = (inspect.getdoc(kind) or "").partition("\n")[0].rstrip(".")
            found += [replace(item, group=own.name, heading=heading) for item in settings_of(kind)]
    return tuple(found)


def settings_from(declared: type[Settings], values: Mapping[str, Any]) -> Settings:
    """A dataclass of settings from values by name, in whatever group they stand.

    Examples
    --------
    >>> from pmmkit.actions.jobs.compare import CompareSettings
    >>> asked = {"model": "kvlcc2", "campaigns": ("mine",), "wave_height": 3.0}
    >>> settings_from(CompareSettings, asked).waves.wave_height
    3.0
    """
    own: dict[str, Any] = {}
    groups: dict[str, dict[str, Any]] = {}
    for item in settings_of(declared):
        if item.name in values:
            place = groups.setdefault(item.group, {}) if item.group else own
            place[item.name] = values[item.name]
    hints = get_type_hints(declared)
    return declared(**own, **{name: hints[name](**given) for name, given in groups.items()})


def values_of(job: Any) -> Iterator[tuple[JobSetting, Any]]:
    """Settings with the values that they have."""
    for item in settings_of(type(job)):
        place = getattr(job, item.group) if item.group else job
        yield item, getattr(place, item.name)


def stated(job: Any) -> dict[str, Any]:
    """The settings that are not what they are if absent."""
    return {item.name: value for item, value in values_of(job) if value != item.default}


def as_typed(job: Any) -> str:
    """The settings of a `job` as they are typed after the name of a command.

    Examples
    --------
    >>> from pmmkit.actions.jobs.compare import CompareSettings
    >>> as_typed(CompareSettings(model="a ship.toml", campaigns=(Path("mine"),), figures=False))
    "'a ship.toml' mine --no-figures"
    """
    values = sorted(values_of(job), key=lambda pair: not pair[0].help.argument)
    return " ".join(word for item, value in values for word in item.typed(value))


def _word(value: Any) -> str:
    """A value of an option on a command line."""
    if isinstance(value, Path):
        return quoted(value)
    if isinstance(value, float):
        return f"{value:g}"
    return "@".join(map(shlex.quote, str(value).split("@")))  # a fault and whose it is


# What is read out of the text of a setting, and what is made of text to be typed.


def cycles_of(text: str | None) -> int | tuple[int, int] | None:
    """Cycles out of text such as 3 or 3-6."""
    if text is None:
        return None
    first, dash, last = text.partition("-")
    try:
        return (int(first), int(last)) if dash else int(first)
    except ValueError:
        raise SettingError(f"{text!r}: write one cycle (3) or a range (3-6).") from None


def stem(path: str | Path) -> str:
    """Name for a folder of results: that of the campaign's folder, or of the file."""
    full = Path(path).resolve()
    named = full.parent if full.name == "campaign.toml" else full
    files = (".toml", ".h5", ".hdf5", ".nc", ".csv", ".mgf", ".zip")
    return named.stem if named.suffix in files else named.name


def present(**settings: Any) -> dict[str, Any]:
    """The settings that are not None."""
    return {name: value for name, value in settings.items() if value is not None}


def orders_of(given: Sequence[str]) -> dict[str, float]:
    """Settings of a manoeuvre out of text such as executes=7."""
    found = {}
    for text in given:
        name, _, value = text.partition("=")
        try:
            found[name.strip().replace("-", "_")] = float(value)
        except ValueError:
            raise SettingError(f"{text!r}: write --set executes=7.") from None
    return found


def words(text: str | Sequence[str] | None) -> list[str]:
    """Names out of text such as memory,current, or out of several such texts."""
    texts = [text] if isinstance(text, str) else text or []
    return " ".join(texts).replace(",", " ").split()


def numbers(text: str | None) -> Sequence[float] | None:
    """Numbers out of text such as 6,9,12."""
    if text is None:
        return None
    try:
        return [float(part) for part in words(text)]
    except ValueError:
        raise SettingError(f"{text!r}: write numbers such as 6,9,12.") from None


def patterns(given: Sequence[str]) -> list[str] | None:
    """Patterns of runs, each text holding one or several with commas between; None for all."""
    if not given:
        return None
    return [part.strip() for text in given for part in text.split(",") if part.strip()]


def sensors_of(text: str | None) -> dict[str, float] | None:
    """Standard deviations out of text such as x=0.03,psi_deg=0.1, angles in radians."""
    if text is None:
        return None
    found = {}
    for part in words(text):
        name, _, value = part.partition("=")
        try:
            number = float(value)
        except ValueError:
            number = math.nan
        if not number > 0.0:
            raise SettingError(f"{part!r}: write --sensors x=0.03,psi_deg=0.1.")
        bare = name.removesuffix("_deg")
        found[bare] = number if bare == name else math.radians(number)
    return found
