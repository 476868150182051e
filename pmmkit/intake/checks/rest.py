"""What the gauges show while the carriage stands, at the head of the records."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.base import DataError
from pmmkit.conventions import CHANNEL_UNITS, CHANNELS
from pmmkit.intake.checks.finding import Check, CheckFinding, figure, straight_line
from pmmkit.numerics import Array
from pmmkit.presentation import WIDE
from pmmkit.signals import head_rest

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign
    from pmmkit.intake.checks.finding import Summary


# The zeros of the gauges from run to run, in the order of the day.


FEWEST: Final = 3
"""Records from which a change over the day is told."""
NOISES: Final = 3.0
"""Standard uncertainties of a zero that the zeros must scatter by."""
LINE: Final = 3.0
"""Standard errors of its slope from which a straight line is told."""


@dataclass(frozen=True, kw_only=True)
class _Zeros:
    """What one gauge shows at rest: places in the day, values and standard uncertainties."""

    channel: str
    day: Array
    value: Array
    std: Array
    size: float

    @property
    def drifts(self) -> bool:
        """Whether they change by more than each of them is uncertain."""
        noise = float(np.median(self.std))
        spread = float(np.std(self.value, ddof=1))
        return spread > NOISES * noise and float(np.ptp(self.value)) > SHARE * self.size

    def words(self) -> str:
        """How they change, in words."""
        unit = CHANNEL_UNITS[self.channel]
        low, high = figure(float(self.value.min())), figure(float(self.value.max()))
        told = f"{self.channel} {low} to {high} {unit}"
        slope, _, error = straight_line(self.day, self.value)
        if self.drifts and abs(slope) > LINE * error:
            told += (
                f" ({figure(slope)} ± {figure(WIDE * error, 2)} {unit} from the first run to the "
                "last)"
            )
        if self.drifts and self.size > 0:
            told += f", {100 * float(np.ptp(self.value)) / self.size:.2g} % of its usual force"
        return told


def examine_zeros(campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """Zeros that change over the day; where they are taken off, what was taken.

    They change if they scatter by three times the uncertainty of each, and by more than 0.2 % of
    the usual force.
    """
    runs = [item.run for item in summaries]
    day = campaign.with_(runs=tuple(runs)).places_in_day
    places = dict(zip((run.id for run in runs), day, strict=True))
    seen = [item for item in summaries if any(f"{name}_zero" in item.facts for name in CHANNELS)]
    seen.sort(key=lambda item: places[item.run.id])
    if len(seen) < FEWEST:
        return
    tared = all(item.facts.get("tared") for item in seen)
    found = [zeros for name in CHANNELS if (zeros := _of(name, seen, places)) is not None]
    changing = [zeros for zeros in found if zeros.drifts]
    if not changing and not tared:
        return
    order = (
        "by the times at which they started"
        if all(run.started for run in runs)
        else "as the campaign file has them"
    )
    head = f"The zeros of the gauges at rest in {len(seen)} of {len(summaries)} records"
    told = "; ".join(zeros.words() for zeros in (changing or found))
    if tared:
        change = f"change over the runs, {order}" if changing else "stay where they are"
        message = f"{head} {change}: {told}. They are taken off each record."
    else:
        message = (
            f"{head} change over the runs, {order}: {told}. No zero that is the same for all runs "
            "takes that off."
        )
    yield CheckFinding(
        check="zeros",
        severity="info" if tared else "warning",
        message=message,
        runs=tuple(item.run.id for item in seen),
        remedy="" if tared else f"Take it off record by record: {_where_to_tare(seen, summaries)}.",
        numbers={f"{x.channel}_range": float(np.ptp(x.value)) for x in changing},
        by_run={
            item.run.id: {
                "day": places[item.run.id],
                **{
                    key: item.facts[f"{zeros.channel}_{kind}"]
                    for zeros in found
                    for key, kind in ((zeros.channel, "zero"), (f"{zeros.channel}_std", "zero_std"))
                    if f"{zeros.channel}_{kind}" in item.facts
                },
            }
            for item in seen
        },
    )


def _of(name: str, seen: Sequence[Summary], places: dict[str, float]) -> _Zeros | None:
    own = [item for item in seen if f"{name}_zero" in item.facts]
    if len(own) < FEWEST:
        return None
    sizes = [item.facts[f"{name}_size"] for item in own if f"{name}_size" in item.facts]
    return _Zeros(
        channel=name,
        day=np.array([places[item.run.id] for item in own]),
        value=np.array([item.facts[f"{name}_zero"] for item in own]),
        std=np.array([item.facts[f"{name}_zero_std"] for item in own]),
        size=float(np.median(sizes)) if sizes and math.isfinite(sizes[0]) else 0.0,
    )


SIGMAS: Final = 4.0
"""Standard errors by which the median zero of the records must lie off."""
SHARE: Final = 2e-3
"""Share of a channel's usual force below which a zero is of no interest."""


def rest_facts(
    t: Array, columns: Mapping[str, Array], tared: Mapping[str, tuple[float, float]]
) -> dict[str, float]:
    """What the channels show at rest; nothing where the record begins on the way.

    t [s]; `columns`: forces, and of the motion what was recorded.
    """
    facts = _rest_left(t, columns)
    for name in CHANNELS:
        if name in tared:
            facts |= {f"{name}_zero": tared[name][0], f"{name}_zero_std": tared[name][1]}
        elif f"{name}_rest" in facts:
            facts |= {
                f"{name}_zero": facts[f"{name}_rest"],
                f"{name}_zero_std": facts[f"{name}_rest_std"],
            }
    return facts | ({"tared": 1.0} if tared else {})


def _rest_left(t: Array, columns: Mapping[str, Array]) -> dict[str, float]:
    names = [name for name in CHANNELS if name in columns]
    if names[:1] != ["X"]:
        return {}
    record = np.stack([columns[name] for name in names])
    try:
        found = head_rest(t, record, motion=columns)
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


def _where_to_tare(standing: Sequence[Summary], summaries: Sequence[Summary]) -> str:
    """Where a file says that zeros are taken off: a run that begins on the way has none."""
    every = len(standing) == len(summaries)
    return "tare = true under [defaults]" if every else "tare = true of each of these runs"


def zeros_off(facts: Sequence[Mapping[str, float]]) -> dict[str, tuple[float, float, float]]:
    """Zeros of gauges that stand off at rest, their standard errors and the usual forces [N, N m].

    Of the facts of records; the median over them counts, against the scatter over them and the
    noise of each. It stands off by four standard errors and 0.2 % of the usual force.
    """
    off = {}
    for name in CHANNELS:
        known = [fact for fact in facts if f"{name}_rest" in fact]
        if not known:
            continue
        values = np.array([fact[f"{name}_rest"] for fact in known])
        noise = float(np.median([fact[f"{name}_rest_std"] for fact in known]))
        zero = float(np.median(values))
        scatter = 1.4826 * float(np.median(np.abs(values - zero)))
        error = 1.25 * max(noise, scatter) / math.sqrt(len(values))
        size = float(np.median([fact[f"{name}_size"] for fact in known]))
        if abs(zero) > max(SIGMAS * error, SHARE * size):
            off[name] = (zero, error, size)
    return off


def examine_rest(_campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """Zeros of the gauges in records that begin at rest, where nothing takes them off."""
    standing = [item for item in summaries if "rest_s" in item.facts]
    words, numbers = [], {}
    for name, (zero, error, size) in zeros_off([item.facts for item in standing]).items():
        words.append(
            f"{name} {figure(zero)} ± {figure(WIDE * error, 2)} {CHANNEL_UNITS[name]} "
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
            remedy="Take it off each record: "
            f"{_where_to_tare(standing, summaries)}, or [[corrections]] with "
            'action = "tare" and these runs.',
            numbers=numbers,
        )


CHECKS = (
    Check("rest", "gauges that do not show zero while the carriage stands", examine_rest),
    Check("zeros", "zeros of the gauges that change over the day", examine_zeros),
)
