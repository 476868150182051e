"""Standard uncertainties that a campaign states: what may be stated, and in which unit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final, Literal

from pmmkit.campaigns.settings import setting_key
from pmmkit.channels import did_you_mean
from pmmkit.errors import DataError

Of = Literal["gauge", "water", "rig", "setting"]


@dataclass(frozen=True, kw_only=True)
class Statable:
    """Something whose standard uncertainty can be stated.

    Parameters
    ----------
    name : str
        Of a `TypeB`.
    unit : str
        In a campaign file, where it states none.
    of : {"gauge", "water", "rig", "setting"}
        What it is an error of: the reading of one channel, the density, the rig and the model on
        it, or what a run was set to.
    """

    name: str
    unit: str
    of: Of

    @property
    def key(self) -> str:
        """Key under ``[uncertainty]``."""
        return setting_key(self.name)

    @property
    def channel(self) -> str | None:
        """The channel of a gauge."""
        return self.name[0] if self.of == "gauge" else None

    @property
    def single(self) -> bool:
        """Whether there is only one in a campaign: its error is the same in all runs."""
        return self.of in ("water", "rig")


_UNITS: Final[Mapping[Of, Mapping[str, str]]] = {
    "gauge": {"X_gauge": "N", "Y_gauge": "N", "N_gauge": "N m", "K_gauge": "N m"},
    "setting": {
        "drift": "deg",
        "heel": "deg",
        "rudder": "deg",
        "speed": "m/s",
        "propeller_rps": "1/s",
        "period": "s",
        "amplitude": "m",
        "yaw_amplitude": "deg",
        "phase": "deg",
        "yaw_rate": "rad/s",
        "radius": "m",
    },
    "water": {"rho": "kg/m3"},
    "rig": {
        "mass": "kg",
        "xG": "m",
        "Izz": "kg m2",
        "moment_reference_x": "m",
        "motion_reference_x": "m",
    },
}
STATABLE: Final[Mapping[str, Statable]] = MappingProxyType(
    {
        name: Statable(name=name, unit=unit, of=of)
        for of, units in _UNITS.items()
        for name, unit in units.items()
    }
)
"""By name. What each does to a run is said by `pmmkit.observations.stated`."""


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

    Examples
    --------
    >>> TypeB(name="drift", std=5e-4).kind.key
    'drift_deg'
    """

    name: str
    std: float
    relative: bool = False
    shared: bool = False

    def __post_init__(self) -> None:
        if self.name not in STATABLE:
            raise DataError(
                f"No uncertainty of {self.name!r} can be stated"
                f"{did_you_mean(self.name, STATABLE) or '.'}"
            )

    @property
    def kind(self) -> Statable:
        """What it is an uncertainty of."""
        return STATABLE[self.name]

    def moved(self, value: float) -> float:
        """A value that is wrong by one standard uncertainty.

        Examples
        --------
        >>> TypeB(name="mass", std=0.01, relative=True).moved(450.0)
        454.5
        """
        return value * (1 + self.std) if self.relative else value + self.std
