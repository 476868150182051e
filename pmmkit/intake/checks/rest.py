"""What the gauges show while the carriage stands, at the head of the records."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.base import DataError
from pmmkit.conventions import CHANNEL_UNITS, CHANNELS
from pmmkit.intake.checks.finding import Check, CheckFinding, figure
from pmmkit.numerics import Array
from pmmkit.presentation import WIDE
from pmmkit.signals import head_rest

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign
    from pmmkit.intake.checks.summary import Summary

SIGMAS: Final = 4.0
"""Standard errors by which the median zero of the records must lie off."""
SHARE: Final = 2e-3
"""Share of a channel's usual force below which a zero is of no interest."""


def rest_facts(
    t: Array, forces: Mapping[str, Array], tared: Mapping[str, tuple[float, float]]
) -> dict[str, float]:
    """What the channels show at rest; nothing where the record begins on the way.

    t [s].
    """
    facts = _rest_left(t, forces)
    for name in CHANNELS:
        if name in tared:
            facts |= {f"{name}_zero": tared[name][0], f"{name}_zero_std": tared[name][1]}
        elif f"{name}_rest" in facts:
            facts |= {
                f"{name}_zero": facts[f"{name}_rest"],
                f"{name}_zero_std": facts[f"{name}_rest_std"],
            }
    return facts | ({"tared": 1.0} if tared else {})


def _rest_left(t: Array, forces: Mapping[str, Array]) -> dict[str, float]:
    names = [name for name in CHANNELS if name in forces]
    if names[:1] != ["X"]:
        return {}
    record = np.stack([forces[name] for name in names])
    try:
        found = head_rest(t, record)
    except DataError:
        return {}
    if found is None:
        return {}
    size = np.sqrt(np.mean(np.square(record[:, found.stop :] - found.value[:, None]), axis=1))
    facts = {"rest_s": found.duration}
    for place, name in enumerate(names):
        facts |= {
            f"{name}_rest": float(found.value[place]),
            f"{name}_rest_std": float(found.std[place]),
            f"{name}_size": float(size[place]),
        }
    return facts


def examine_rest(_campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """Zeros of the gauges in records that begin at rest, where nothing takes them off.

    The median over the records counts, against the scatter over them and the noise of each; it is
    told if it lies four standard errors off and is more than 0.2 % of the usual force.
    """
    standing = [item for item in summaries if "rest_s" in item.facts]
    words, numbers = [], {}
    for name in CHANNELS:
        facts = [item.facts for item in standing if f"{name}_rest" in item.facts]
        if not facts:
            continue
        values = np.array([fact[f"{name}_rest"] for fact in facts])
        noise = float(np.median([fact[f"{name}_rest_std"] for fact in facts]))
        zero = float(np.median(values))
        scatter = 1.4826 * float(np.median(np.abs(values - zero)))
        error = 1.25 * max(noise, scatter) / math.sqrt(len(values))
        size = float(np.median([fact[f"{name}_size"] for fact in facts]))
        if abs(zero) > max(SIGMAS * error, SHARE * size):
            unit = CHANNEL_UNITS[name]
            words.append(
                f"{name} {figure(zero)} ± {figure(WIDE * error, 2)} {unit} "
                f"({100 * abs(zero) / size:.2g} % of its usual force)"
            )
            numbers[name] = zero
    if words:
        seconds = float(np.median([item.facts["rest_s"] for item in standing]))
        yield CheckFinding(
            check="rest",
            severity="warning",
            message=f"{len(standing)} of {len(summaries)} records begin with the carriage at rest, "
            f"about {figure(seconds, 2)} s, and the gauges do not show zero there: "
            f"{', '.join(words)}. Nothing takes it off; in X it is taken for resistance.",
            runs=tuple(item.run.id for item in standing),
            remedy="Take it off each record: tare = true under [defaults], or [[corrections]] with "
            'action = "tare" and these runs.',
            numbers=numbers,
        )


CHECKS = (Check("rest", "gauges that do not show zero while the carriage stands", examine_rest),)
