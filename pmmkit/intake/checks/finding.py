"""What a check says, and the list that keeps the checks together."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Final, Literal

import numpy as np

from pmmkit.base import ContradictionError, Problem
from pmmkit.campaigns import Run
from pmmkit.conventions import CHANNEL_UNITS, CHANNELS
from pmmkit.numerics import Array
from pmmkit.presentation import Grid, Group, with_uncertainty

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign, Correction


# What the checks know of a run: a few kilobytes, whatever the length of its record.


EMPTY: Final[Array] = np.zeros(0)


@dataclass(frozen=True, kw_only=True)
class Summary:
    """One run in a few numbers, SI and radians.

    Parameters
    ----------
    run : Run
        The run (its samples are not kept).
    means : mapping of str to float
        Mean of each force channel: of the steady window, of the row, or harmonic 0.
    cos, sin : mapping of str to array (4,)
        Harmonics 0 to 3 of forces and motions of an oscillating run, θ = ωt with the motion
        ∝ sin θ: cosines in phase with the velocity, sines with the displacement. ``cos`` at 0 is
        the mean.
    cycles : mapping of str to array (cycles, 7)
        The same cycle by cycle, order C0, C1, S1, C2, S2, C3, S3; only from histories.
    harmonic_noise, cycle_noise : mapping of str to float
        Standard error of a first harmonic of the record (of the mean of a steady one), and of
        one cycle.
    digest : str
        Hash of the force values.
    sketch : array
        A few dozen force values, scaled, by which near copies are found.
    facts : mapping of str to float
        Facts about times, flat stretches and motions, by name.
    refused : Problem, optional
        Why the record cannot be reduced; nothing but the facts of its clock is known then.
    """

    FLAT_SAMPLES: ClassVar[int] = 5
    """Equal samples from which a stretch of a record is flat."""

    run: Run
    means: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    cos: Mapping[str, Array] = field(default_factory=lambda: MappingProxyType({}))
    sin: Mapping[str, Array] = field(default_factory=lambda: MappingProxyType({}))
    cycles: Mapping[str, Array] = field(default_factory=lambda: MappingProxyType({}))
    harmonic_noise: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    cycle_noise: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    digest: str = ""
    sketch: Array = field(default_factory=lambda: EMPTY)
    facts: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    refused: Problem | None = None

    def without(self, names: Collection[str]) -> Summary:
        """The run without some force channels, as if they had not been measured."""
        parts: dict[str, Any] = {
            part: {key: x for key, x in getattr(self, part).items() if key not in names}
            for part in ("means", "cos", "sin", "cycles", "harmonic_noise", "cycle_noise")
        }
        return replace(self, **parts)

    def c(self, name: str, order: int) -> float:
        """Harmonic in phase with the velocity; nan where it is not known."""
        return float(self.cos[name][order]) if name in self.cos else math.nan

    def s(self, name: str, order: int) -> float:
        """Harmonic in phase with the displacement; nan where it is not known."""
        return float(self.sin[name][order]) if name in self.sin else math.nan

    def mean(self, name: str) -> float:
        """Mean of a force; nan where it is not known."""
        return float(self.means.get(name, math.nan))

    def level(self, name: str) -> float:
        """Largest harmonic (1 to 3) of a channel in magnitude; 0 where it is not known."""
        if name not in self.cos:
            return 0.0
        return float(np.hypot(self.cos[name][1:], self.sin[name][1:]).max())


Severity = Literal["error", "warning", "info"]
SEVERITIES: Final[tuple[Severity, ...]] = ("error", "warning", "info")


@dataclass(frozen=True, kw_only=True)
class CheckFinding:
    """One thing that a check has to say.

    Parameters
    ----------
    check : str
        Name of the check, as in `CHECKS`.
    severity : {"error", "warning", "info"}
        ``error``: the data contradict themselves or the campaign file, nothing may be fitted.
        ``warning``: suspicious. ``info``: worth knowing.
    message : str
        A sentence with its numbers and what they should be.
    runs : tuple of str
        The runs it speaks of.
    remedy : str
        What the user can do.
    numbers : mapping of str to float
        The numbers by name, for programs.
    channels : tuple of str
        The channels that are at fault, where it is they.
    by_run : mapping of str to mapping
        Numbers of each run, in the order in which they are shown.
    cause : str
        What is thought to be wrong: the name of the fault in the catalogue, or what a slip is
        called; empty where the check names none.
    """

    check: str
    severity: Severity
    message: str
    runs: tuple[str, ...] = ()
    remedy: str = ""
    numbers: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    channels: tuple[str, ...] = ()
    cause: str = ""
    by_run: Mapping[str, Mapping[str, float]] = field(default_factory=lambda: MappingProxyType({}))

    def __str__(self) -> str:
        where = f" ({name_runs(self.runs)})" if self.runs else ""
        return f"{self.severity}: {self.check}{where}: {self.message}".rstrip()

    @property
    def rank(self) -> int:
        """How loud it is: errors first, then warnings, then what is worth knowing."""
        return SEVERITIES.index(self.severity)

    @property
    def gauges(self) -> tuple[str, ...]:
        """The gauges of which it has a number of each run, such as their zeros at rest."""
        return tuple(x for x in CHANNELS if any(x in own for own in self.by_run.values()))

    def grid(self) -> Grid:
        """The zeros of each run as a table, in the order of the day."""
        channels = self.gauges
        return Grid(
            head=["run", *(f"{name} at rest [{CHANNEL_UNITS[name]}]" for name in channels)],
            groups=[
                Group(
                    rows=[
                        [
                            run,
                            *(
                                with_uncertainty(own[name], own[f"{name}_std"])
                                if name in own
                                else None
                                for name in channels
                            ),
                        ]
                        for run, own in self.by_run.items()
                    ]
                )
            ],
        )

    def to_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "check": self.check,
            "severity": self.severity,
            "message": self.message,
            "runs": list(self.runs),
            "remedy": self.remedy,
            "numbers": dict(self.numbers),
            "channels": list(self.channels),
            "cause": self.cause,
            **(
                {"by_run": {name: dict(x) for name, x in self.by_run.items()}}
                if self.by_run
                else {}
            ),
        }


@dataclass(frozen=True)
class Check:
    """A check: its name, what it looks for in one line, and the function that looks.

    `name, description`: name, and what it looks for. `examine`: takes the campaign and the
    summaries of its runs, gives findings. `by_particulars`: it judges by the ship's length,
    volume or mass, and says nothing where these are wrong.
    """

    name: str
    description: str
    examine: Callable[[Campaign, Sequence[Summary]], Iterable[CheckFinding]]
    by_particulars: bool = False


def refuse(findings: Iterable[CheckFinding]) -> None:
    """Raise one error that lists all findings of severity ``error``; do nothing without any.

    Parameters
    ----------
    findings : iterable of CheckFinding
        As `examine` gives them.

    Raises
    ------
    ContradictionError
        With every error at once. Warnings do not raise.

    Examples
    --------
    >>> refuse([CheckFinding(check="copies", severity="warning", message="one comes twice")])
    >>> try:
    ...     refuse([CheckFinding(check="units", severity="error", message="Y is 9.8 times too big",
    ...                          runs=("SD_1",), remedy="State the unit kgf.")])
    ... except ContradictionError as error:
    ...     print(error)
    The data contradict themselves or the campaign file: run SD_1: [units] Y is 9.8 times too big
    State the unit kgf.
    """
    problems = [
        Problem(
            message=f"[{finding.check}] {finding.message}",
            run=name_runs(finding.runs) if finding.runs else None,
            remedy=finding.remedy or None,
        )
        for finding in findings
        if finding.severity == "error"
    ]
    if problems:
        raise ContradictionError(
            problems, title="The data contradict themselves or the campaign file"
        )


def accepted(campaign: Campaign, finding: CheckFinding) -> CheckFinding:
    """The finding, or a remark with the reason where the campaign file accepts it.

    A correction with ``action = "accept"`` takes it for the runs that it names: all runs of the
    finding must be named. What speaks of no run is accepted for ``runs = ["*"]``.
    """
    if finding.severity == "info":
        return finding
    reasons: dict[str, None] = {}
    taken = [
        (run.id, [item for item in run.corrections if _accepts(item, finding)])
        for run in (*campaign.runs, *campaign.check_loads)
        if run.id in finding.runs or not finding.runs
    ]
    if not taken or not all(items for _, items in taken):
        return finding
    for _, items in taken:
        reasons |= {item.reason: None for item in items}
    return replace(
        finding,
        severity="info",
        message=f"{finding.message} Accepted by the campaign file: {'; '.join(reasons)}",
        remedy="",
    )


def _accepts(item: Correction, finding: CheckFinding) -> bool:
    named = item.action == "accept" and item.values.get("check") == finding.check
    return named and (bool(finding.runs) or "*" in item.runs)


def name_runs(ids: Sequence[str], most: int = 4) -> str:
    """Some `ids` in a short list, at most `most` of them.

    Examples
    --------
    >>> name_runs(["a", "b", "c", "d", "e", "f"])
    'a, b, c, … f (6 runs)'
    """
    if len(ids) <= most:
        return ", ".join(ids)
    return f"{', '.join(ids[: most - 1])}, … {ids[-1]} ({len(ids)} runs)"


def figure(value: float, digits: int = 3) -> str:
    """A number in a sentence: three significant digits, no needless exponent.

    Examples
    --------
    >>> figure(5342.7), figure(-0.00123456), figure(0.0323)
    ('5340', '-0.00123', '0.0323')
    """
    if not math.isfinite(value) or value == 0:
        return f"{value:g}"
    power = math.floor(math.log10(abs(value)))
    if power < -4 or power > 6:
        return f"{value:.{digits - 1}e}"
    return f"{round(value, digits - 1 - power):.{max(0, digits - 1 - power)}f}"


def share_of(x: Array, y: Array) -> tuple[float, float]:
    """Slope of y on x through the origin, and its standard error from the scatter.

    The error of a single pair is nan.

    Examples
    --------
    >>> import numpy as np
    >>> share_of(np.array([1., 2., 3.]), np.array([2., 4., 6.]))
    (2.0, 0.0)
    """
    power = float(x @ x)
    if power == 0:
        return math.nan, math.nan
    slope = float(x @ y) / power
    if len(x) < 2:
        return slope, math.nan
    rest = y - slope * x
    return slope, math.sqrt(float(rest @ rest) / (len(x) - 1) / power)


def straight_line(x: Array, y: Array) -> tuple[float, float, float]:
    """Slope, intercept and standard error of the slope of a straight line.

    Examples
    --------
    >>> import numpy as np
    >>> slope, intercept, error = straight_line(np.array([0., 1., 2.]), np.array([1., 3., 5.]))
    >>> round(slope, 9), round(intercept, 9), round(error, 9)
    (2.0, 1.0, 0.0)
    """
    centred = x - x.mean()
    power = float(centred @ centred)
    if power == 0:
        return math.nan, float(y.mean()), math.nan
    slope = float(centred @ y) / power
    intercept = float(y.mean()) - slope * float(x.mean())
    rest = y - slope * x - intercept
    free = len(x) - 2
    error = math.sqrt(float(rest @ rest) / free / power) if free > 0 else math.nan
    return slope, intercept, error
