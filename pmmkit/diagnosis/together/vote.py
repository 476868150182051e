"""What one campaign says of sets of effects, its own faults taken out."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, Protocol

from pmmkit.diagnosis.evidence import Entry
from pmmkit.diagnosis.findings import Diagnosis
from pmmkit.diagnosis.together.belongs import Measured
from pmmkit.effects.catalogue import is_fault
from pmmkit.models import Model

Names = tuple[str, ...]
Kind = Literal["captive", "free-running"]


@dataclass(frozen=True, kw_only=True)
class Ballot:
    """What a campaign says of a set of effects.

    Parameters
    ----------
    log_evidence : float
        ln of how much more probable the campaign is with the set and the faults that it then has
        than with its own faults alone. The set pays no price here, each fault does.
    faults : tuple of str
        The faults beside the set.
    linear : bool
        Whether it is by a linear problem alone, where the equations themselves might be asked.
    """

    log_evidence: float
    faults: Names = ()
    linear: bool = False


@dataclass(frozen=True, kw_only=True, eq=False)
class Sized:
    """An effect as a campaign measures it: what of, usual sizes, values with their covariance."""

    coefficients: Names
    typical: tuple[float, ...]
    measured: Measured


class Vote(Protocol):
    """A campaign that has been diagnosed, and can be asked for more sets of effects."""

    @property
    def name(self) -> str:
        """Of the campaign."""

    @property
    def kind(self) -> Kind:
        """How the ship was tested."""

    @property
    def diagnosis(self) -> Diagnosis:
        """Of the campaign alone."""

    @property
    def asked(self) -> frozenset[str]:
        """Effects of the ship that this campaign was asked for."""

    @property
    def kept(self) -> frozenset[Names]:
        """Sets that its own diagnosis fitted, and that predict what is left out better."""

    def promised(self, names: Names) -> Ballot:
        """A set, as far as is known without another fit."""

    def weighed(self, names: Names) -> Ballot | None:
        """A set after its own fit; None if that fit leads nowhere."""

    def sizes(self, names: Names, faults: Names) -> Mapping[str, Sized]:
        """The effects of a set, fitted together."""

    def model_with(self, names: Names, faults: Names) -> Model | None:
        """The model with a set, all fitted to this campaign; None without a complete model."""


def of_ship(names: Iterable[str]) -> Names:
    """Effects of the ship, for which campaigns vote together; in one order."""
    return tuple(sorted(name for name in names if not is_fault(name)))


def asked_in(entries: Sequence[Entry]) -> frozenset[str]:
    """Effects of the ship that stand in sets."""
    return frozenset(name for item in entries for name in of_ship(item.names))


def fault_sets(entries: Sequence[Entry], most: int) -> list[Names]:
    """The best sets of faults alone that are worth their price."""
    found = [item for item in entries if not of_ship(item.names) and item.log_evidence > 0.0]
    return [item.names for item in sorted(found, key=lambda item: -item.log_evidence)[:most]]


def faults_beside(entries: Sequence[Entry], names: Names) -> Names:
    """The faults of the best set that has just these effects of the ship; none if there is none."""
    same = [item for item in entries if set(of_ship(item.names)) == set(names)]
    if not same:
        return ()
    best = max(same, key=lambda item: item.log_evidence)
    return tuple(name for name in best.names if is_fault(name))
