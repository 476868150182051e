"""Channels that lost, or repeated, single values: late or early from there on."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Final

from pmmkit.intake.checks.finding import Check, CheckFinding, Summary, figure
from pmmkit.numerics import Array
from pmmkit.presentation import counted
from pmmkit.signals import FourierBasis, shifts_within

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign

CHANNELS: Final = ("X", "Y", "N", "K")


def late_facts(t: Array, basis: FourierBasis, forces: Mapping[str, Array]) -> Mapping[str, float]:
    """By how many samples channels are late from some time on; nothing of those that are not.

    t [s]; basis at these times; forces by channel.

    Examples
    --------
    >>> import numpy as np
    >>> t = np.arange(0.0, 60.0, 0.1)
    >>> wave = np.cos(2 * np.pi * t / 10) + 0.01 * np.random.default_rng(0).normal(size=t.size)
    >>> lost = np.append(np.delete(wave, 310), wave[0])
    >>> facts = late_facts(t, FourierBasis.at(2 * np.pi * t / 10, 5), {"Y": wave, "N": lost})
    >>> sorted(facts), facts["N_late"], round(facts["N_late_from"])
    (['N_late', 'N_late_from', 'N_late_sigmas'], -1.0, 31)
    """
    facts: dict[str, float] = {}
    if not forces:
        return facts
    for name, found in zip(forces, shifts_within(basis, [*forces.values()]), strict=True):
        if found is not None:
            facts[f"{name}_late"] = float(found.samples)
            facts[f"{name}_late_from"] = float(t[found.start])
            facts[f"{name}_late_sigmas"] = found.sigmas
    return facts


def examine_late(_campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """Channels of oscillating runs that are late or early by one to three samples from some time
    on: a logger that lost a value, or repeated one."""
    timed = [item for item in summaries if item.run.kind == "history" and item.run.dynamic]
    for channel in CHANNELS:
        hit = [item for item in timed if f"{channel}_late" in item.facts]
        if not hit:
            continue
        worst = max(hit, key=lambda item: item.facts[f"{channel}_late_sigmas"])
        late, start, sigmas = (
            worst.facts[f"{channel}_late{what}"] for what in ("", "_from", "_sigmas")
        )
        many = f"; so in {len(hit)} of {len(timed)} runs" if len(hit) > 1 else ""
        yield CheckFinding(
            check="late channels",
            severity="warning",
            message=f"{channel} is {'late' if late > 0 else 'early'} by "
            f"{counted(int(abs(late)), 'sample')} from t = {figure(start, 4)} s in "
            f"{worst.run.id}{many}.",
            runs=tuple(item.run.id for item in hit),
            remedy="Look where the logger lost or repeated values, and mend that at its source; or "
            'leave out what follows (action = "trim").',
            numbers={"samples": late, "from": start, "sigmas": sigmas},
            channels=(channel,),
        )


CHECKS = (
    Check(
        "late channels",
        "channels that are late or early by whole samples from some time on",
        examine_late,
    ),
)
