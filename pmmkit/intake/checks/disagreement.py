"""Runs that disagree with the others: a kind of test, a speed, a side, a part of the day.

In the runs S of a group a channel reads F (1 + g) + a + b β in place of F: a gain, an offset and a
slope in the drift angle, each 0 ± s of the channel's force, s averaged over `Run.OTHERWISE`.
Checks, reduction, comparison and diagnosis ask it here, each beside what it has fitted.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from pmmkit.campaigns import Run
from pmmkit.inference import Normal
from pmmkit.intake.checks.finding import CheckFinding
from pmmkit.models import odds
from pmmkit.numerics import Array
from pmmkit.presentation import counted

Beside = tuple[Array, Normal]
"""Columns (m, q) that stand beside a group, and what the data say of them."""


@dataclass(frozen=True, kw_only=True)
class Disagreement:
    """A group of runs in which a channel reads otherwise than in all others.

    Parameters
    ----------
    channel, group : str
        The channel, and the group in words.
    runs : tuple of str
        Names of its runs.
    gain : float
        What it reads more, as a share of the force [-].
    offset : float
        What its means read more, over the rms force [-].
    log_odds, instead : float
        ln of the odds for it beside the answer, and in its place.
    rival : bool
        Whether it is told because it explains as much in the answer's place.
    """

    TOLD: ClassVar[float] = math.log(20.0)
    """ln odds, the number of groups paid, from which a group is told. Of fifteen faults of groups
    in the virtual tank one is told at each Froude number by itself, six in one fit over all speeds,
    where the day and the speed do not stand for each other (scripts.studies.group_faults)."""

    channel: str
    group: str
    runs: tuple[str, ...]
    gain: float
    offset: float
    log_odds: float
    instead: float
    rival: bool = False

    def __str__(self) -> str:
        who = f"{self.channel} {self.group} ({counted(len(self.runs), 'run')})"
        if self.rival:
            return f"an error of {who} would explain as much"
        size, side = 100.0 * abs(self.gain), "more" if self.gain > 0.0 else "less"
        return (
            f"{who} disagrees with the others ({odds(self.log_odds)}): "
            f"it reads {size:.1f} % {side}, offset {100.0 * self.offset:+.1f} % of the rms force"
        )

    @property
    def finding(self) -> CheckFinding:
        """The same as the checks say it."""
        return CheckFinding(
            check="odd_group",
            severity="warning",
            message=f"{self}.",
            runs=self.runs,
            remedy=(
                "Look at what was changed between them and the others: gauge, zero, model, speed. "
                "Correct or exclude them in the campaign file with the reason."
            ),
            numbers={"gain": self.gain, "offset": self.offset, "log_odds": self.log_odds},
            channels=(self.channel,),
            cause="odd_group",
        )

    @staticmethod
    def price(groups: int, channels: int) -> float:
        """ln of the odds against one group in one channel, of so many that are asked."""
        return math.log(2.0 * max(groups * channels, 1))

    @classmethod
    def among(
        cls,
        channel: str,
        groups: Mapping[str, frozenset[str]],
        ids: NDArray[np.object_],
        columns: Array,
        data: Array,
        *,
        price: float,
        left: Callable[[Array], Array] = np.asarray,
        beside: tuple[Beside, Beside] | None = None,
    ) -> Iterator[Disagreement]:
        """Each group that has some of the rows of a channel, but not all.

        Parameters
        ----------
        channel : str
            Its name.
        groups : mapping of str to frozenset of str
            As `Run.groups` gives them.
        ids : array of str (n,)
            The run of each row.
        columns : array (n, p)
            What a group may read otherwise, at size one: force, rms force in the rows of means, and
            whatever else.
        data : array (m,)
            What is left of the rows, over the root of its covariance.
        price : float
            As `price` gives it.
        left : callable
            From columns (n, k) to what is left of them beside what is fitted anyway (m, k).
        beside : pair of (columns, Normal)
            What stands beside the group where it takes the place of an answer, and beside the
            answer; nothing by default.

        Examples
        --------
        Two runs of four read 4 % more.

        >>> ids, force = np.array(list("aabbccdd"), object), np.array([5.0, -7.0] * 4)
        >>> columns = 100.0 * np.column_stack([force, np.tile([6.0, 0.0], 4)])
        >>> data = 4.0 * force * np.isin(ids, ["a", "b"])
        >>> (found,) = Disagreement.among(
        ...     "Y", {"in pure sway": frozenset("ab")}, ids, columns, data, price=0.0)
        >>> str(found)[:65]
        'Y in pure sway (2 runs) disagrees with the others (over 1000 to 1'
        >>> round(found.gain, 3)
        0.04
        """
        names, places = np.unique(ids, return_inverse=True)
        inside = {x: np.array([name in own for name in names])[places] for x, own in groups.items()}
        there = [words for words, rows in inside.items() if rows.any() and not rows.all()]
        if not there:
            return
        every = left(np.column_stack([columns * inside[x][:, None] for x in there]))
        none = np.zeros((len(data), 0))
        known = beside or 2 * ((none, Normal.of(none, data)),)
        for words, own in zip(there, np.split(every, len(there), axis=1), strict=True):
            products = (own.T @ own, own.T @ data)
            yield cls.of(
                channel,
                words,
                groups[words],
                *(normal.added(*products, x.T @ own, Run.OTHERWISE) for x, normal in known),
                price=price,
            )

    @staticmethod
    def spread_by(columns: Array) -> Callable[[Array], Array]:
        """From columns (n, k) to what whitens them where the rows may be off by others as well.

        Parameters
        ----------
        columns : array (n, q)
            By which the rows may be off, over the root of the covariance of the rest, each at one
            standard deviation: the covariance is ``1 + columns columns'``.
        """
        U, sizes, _ = np.linalg.svd(columns, full_matrices=False)
        taken = 1.0 - 1.0 / np.sqrt(1.0 + sizes**2)

        def left(rows: Array) -> Array:
            found: Array = rows - U @ (taken[:, None] * (U.T @ rows))
            return found

        return left

    @classmethod
    def of(
        cls,
        channel: str,
        group: str,
        runs: frozenset[str],
        instead: tuple[float, Array],
        beside: tuple[float, Array],
        *,
        price: float,
    ) -> Disagreement:
        """From what `Normal.added` says of its columns in the place of an answer, and beside it."""
        log_odds, mean = beside
        return cls(
            channel=channel,
            group=group,
            runs=tuple(sorted(runs)),
            gain=float(mean[0]),
            offset=float(mean[1]),
            log_odds=log_odds - price,
            instead=instead[0] - price,
        )

    @classmethod
    def told(cls, found: Iterable[Disagreement], least: float = TOLD) -> tuple[Disagreement, ...]:
        """Of each channel the group of the most evidence, where it is enough."""
        best: dict[str, Disagreement] = {}
        for item in found:
            if item.log_odds > (best[item.channel].log_odds if item.channel in best else least):
                best[item.channel] = item
        return tuple(best.values())

    @classmethod
    def telling(
        cls, found: Sequence[Disagreement], log_evidence: float
    ) -> tuple[Disagreement, ...]:
        """The group that disagrees most beside an answer, and the one that explains as much in its
        place, where there are such.

        log_evidence: ln evidence of the answer, its price paid; infinite where there is none.
        """
        beside = max(found, key=lambda item: item.log_odds, default=None)
        most = max(found, key=lambda item: item.instead, default=None)
        told = [beside] if beside is not None and beside.log_odds > cls.TOLD else []
        if most is not None and most not in told and most.instead > log_evidence - cls.TOLD:
            told.append(replace(most, rival=True))
        return tuple(told)
