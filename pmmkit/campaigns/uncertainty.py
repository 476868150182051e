"""Standard uncertainties that a campaign states: what may be stated, and in which unit."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import ClassVar, Final, Literal

from pmmkit.base import DataError, Registry, did_you_mean
from pmmkit.campaigns.run_settings import RUN_SETTINGS

Of = Literal["gauge", "cross-talk", "water", "rig", "hull", "setting"]


@dataclass(frozen=True)
class Statable:
    """Something whose standard uncertainty can be stated.

    `unit`: in a campaign file, where it states none. `of`: what it is an error of: the reading
    of one channel, what one channel shows of another, the density, the rig and the model on it,
    the size of the hull, or what a run was set to. `zero`: what an error of a setting that all
    runs share is called, where it is one of the zero and not of the scale.
    """

    name: str
    unit: str
    of: Of
    title: str
    zero: str = ""

    @property
    def key(self) -> str:
        """Key under ``[uncertainty]``."""
        return RUN_SETTINGS.key_of(self.name)

    @property
    def channel(self) -> str | None:
        """The channel of a gauge."""
        return self.name[0] if self.of == "gauge" else None

    @property
    def channels(self) -> tuple[str, ...]:
        """The channels that an error needs; of cross-talk first the one that shows the other."""
        if self.of == "cross-talk":
            return self.name[0], self.name[-1]
        return (self.name[0],) if self.of == "gauge" else ()

    @property
    def single(self) -> bool:
        """Whether there is only one in a campaign: its error is the same in all runs."""
        return self.of not in ("gauge", "setting")


_KNOWN: Final[Mapping[Of, Mapping[str, tuple[str, ...]]]] = {
    "gauge": {
        "X_gauge": ("N", "gauge of X"),
        "Y_gauge": ("N", "gauge of Y"),
        "N_gauge": ("N m", "gauge of N"),
        "K_gauge": ("N m", "gauge of K"),
    },
    "cross-talk": {
        "X_from_Y": ("-", "cross-talk: X of Y"),
        "X_from_N": ("1/m", "cross-talk: X of N"),
        "Y_from_X": ("-", "cross-talk: Y of X"),
        "Y_from_N": ("1/m", "cross-talk: Y of N"),
        "N_from_X": ("m", "cross-talk: N of X"),
        "N_from_Y": ("m", "cross-talk: N of Y"),
    },
    "water": {"rho": ("kg/m3", "density of the water")},
    "hull": {"L": ("m", "length of the model")},
    "rig": {
        "mass": ("kg", "mass"),
        "xG": ("m", "centre of gravity"),
        "Izz": ("kg m2", "yaw inertia"),
        "moment_reference_x": ("m", "point of the moments"),
        "motion_reference_x": ("m", "point of the motion"),
    },
}


def _statable() -> Iterator[Statable]:
    """What can be stated, the settings after gauges and cross-talk."""
    for of, known in _KNOWN.items():
        if of == "water":
            yield from (
                Statable(item.name, item.unit, "setting", item.title or item.word, item.zero_error)
                for item in RUN_SETTINGS.ordered("drift", "heel", "rudder")
                if item.stated_std
            )
        yield from (Statable(name, words[0], of, *words[1:]) for name, words in known.items())


CENTRE_STD: Final = 0.02
"""Standard uncertainty of a centre of gravity that nobody states, taken at midship, over L: those
of the library's ships lie -0.023 to 0.035 L before it."""


@dataclass(frozen=True, kw_only=True)
class TypeB:
    """A standard uncertainty that the user states (GUM type B).

    Parameters
    ----------
    name : str
        Of `STATABLE`.
    std : float
        Standard uncertainty, SI (radians); a share where `relative`.
    relative : bool
        True for a gain: a share of the value.
    shared : bool
        True if all runs have the same error, False if each run draws its own.
    common : str
        Name of a cause that errors share, such as the weights of a calibration: those of one name
        are errors of the same sign and number of standard deviations. Empty for none.
    assumed : bool
        Whether it stands for a particular that nobody states.

    Examples
    --------
    >>> TypeB(name="drift", std=5e-4).kind.key
    'drift_deg'
    """

    name: str
    std: float
    relative: bool = False
    shared: bool = False
    common: str = ""
    assumed: bool = False
    STATABLE: ClassVar[Registry[Statable]] = Registry(Statable, _statable, what="uncertainty")
    """By name. What each does to a run is said by `pmmkit.reduction.observations.stated`."""

    def __post_init__(self) -> None:
        if self.name not in self.STATABLE:
            raise DataError(
                f"No uncertainty of {self.name!r} can be stated"
                f"{did_you_mean(self.name, self.STATABLE) or '.'}"
            )
        if self.common and not self.shared:
            raise DataError(
                f"The uncertainty of {self.kind.key} has a common cause, {self.common!r}, so all "
                "runs share it: state shared = true."
            )

    @property
    def kind(self) -> Statable:
        """What it is an uncertainty of."""
        return self.STATABLE[self.name]

    @property
    def title(self) -> str:
        """In words: what is uncertain, and which kind of error it is.

        Examples
        --------
        >>> TypeB(name="Y_gauge", std=0.002, relative=True, shared=True).title
        'gauge of Y: calibration'
        >>> TypeB(name="drift", std=5e-4).title
        'drift angle: setting of each run'
        """
        known = self.kind
        if self.assumed:
            return f"{known.title}, which nobody states"
        if known.single:
            return known.title
        if known.of == "gauge":
            shared, own = ("calibration", "gain") if self.relative else ("zero", "zero")
        else:
            shared, own = known.zero or "calibration", "setting"
        return f"{known.title}: {shared if self.shared else f'{own} of each run'}"

    def moved(self, value: float) -> float:
        """A value that is wrong by one standard uncertainty.

        Examples
        --------
        >>> TypeB(name="mass", std=0.01, relative=True).moved(450.0)
        454.5
        """
        return value * (1 + self.std) if self.relative else value + self.std
