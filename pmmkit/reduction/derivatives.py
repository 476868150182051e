"""Which derivatives a campaign is asked for: the structure and what its tests add."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from pmmkit.campaigns import Run
from pmmkit.conventions import CHANNELS, Structure, parse_derivative


@dataclass(frozen=True, kw_only=True)
class DerivativeNames:
    """Names by channel: those asked for, and those taken where they spoil nothing."""

    required: Mapping[str, tuple[str, ...]]
    optional: Mapping[str, tuple[str, ...]]

    @property
    def names(self) -> dict[str, tuple[str, ...]]:
        """All names by channel, the required ones first."""
        return {
            channel: (*self.required[channel], *self.optional[channel]) for channel in self.required
        }

    def only(self, factors: Iterable[str], *, optional: bool = True) -> DerivativeNames:
        """The columns whose factors are all among those given (constants always are)."""
        allowed = {"0", *factors}

        def inside(name: str) -> bool:
            return parse_derivative(name).variables <= allowed

        return DerivativeNames(
            required={c: tuple(filter(inside, names)) for c, names in self.required.items()},
            optional={
                c: tuple(filter(inside, names)) if optional else ()
                for c, names in self.optional.items()
            },
        )


def columns_of(
    structure: Structure, runs: Iterable[Run], channels: Iterable[str]
) -> DerivativeNames:
    """The derivatives of a structure with what rudder, heel and propeller runs add.

    Parameters
    ----------
    structure : Structure
        What the user asks for.
    runs : iterable of Run
        The tests; rudder runs add δ terms, heeled runs φ terms.
    channels : iterable of str
        Channels that were measured.

    Returns
    -------
    DerivativeNames
        Optional ones: the zero offset of Y, N and K, the thrust term of X, and the higher δ and φ
        terms.
    """
    tests = list(runs)
    measured = [channel for channel in CHANNELS if channel in set(channels)]
    required = {
        channel: list(structure.of(channel)) for channel in measured if structure.of(channel)
    }
    optional: dict[str, list[str]] = {
        channel: ["XT"] if channel == "X" else [f"{channel}0"] for channel in required
    }
    ruddered = [run for run in tests if run.settings.largest_rudder]
    heeled = [run for run in tests if run.settings.heel]
    if ruddered:
        _add(required, {"X": "dd", "Y": "d", "N": "d"})
        _add(optional, {"Y": "ddd", "N": "ddd"})
        if any(run.settings.drift for run in ruddered):
            _add(optional, {"X": "vd", "Y": "vvd vdd", "N": "vvd vdd"})
    if any(run.kind_of_test.yaws and run.kind_of_test.turns_rudder for run in tests):
        _add(optional, {"X": "rd", "Y": "rrd rdd", "N": "rrd rdd"})
    if heeled:
        _add(required, {"Y": "phi", "N": "phi", "K": "phi"})
        _add(optional, {"X": "phiphi"})
        if any(run.settings.drift for run in heeled):
            _add(optional, {"Y": "vvphi vphiphi", "N": "vvphi vphiphi"})
    return DerivativeNames(
        required={channel: tuple(dict.fromkeys(names)) for channel, names in required.items()},
        optional={
            channel: tuple(name for name in names if name not in required[channel])
            for channel, names in optional.items()
        },
    )


def _add(names: dict[str, list[str]], terms: Mapping[str, str]) -> None:
    for channel, listed in terms.items():
        if channel in names:
            names[channel] += [channel + term for term in listed.split()]
