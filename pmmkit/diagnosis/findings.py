"""What a diagnosis says: verdict, group of rivals, findings with their evidence, coverage."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, Literal

from pmmkit.conventions import CHANNEL_UNITS, CHANNELS
from pmmkit.diagnosis.empirical import EmpiricalFormula
from pmmkit.diagnosis.evidence import RankedSet, Visible, Weight, finite, weight_of, with_or_without
from pmmkit.diagnosis.outside import PERHAPS, HiddenEntries, Outside
from pmmkit.intake import Disagreement, Untold
from pmmkit.models import Model, odds
from pmmkit.presentation import WIDE, Described, Grid, Group, Section, counted, listed, number

if TYPE_CHECKING:
    import pandas as pd

    from pmmkit.plotting import Figure

UNITS: Final[Mapping[str, str]] = CHANNEL_UNITS | {
    "heading": "deg",
    "position": "m",
    "speed": "m/s",
    "yaw_rate": "deg/s",
}
"""Of the errors: forces and moments, or how free-running records are missed."""
Verdict = Literal["noise", "refit", "missing_effect", "suspected", "unexplained"]
VERDICTS: Final[Mapping[Verdict, str]] = {
    "noise": "Nothing is missing that these runs could show.",
    "refit": "No effect is missing that these runs could show: values of the model are others.",
    "missing_effect": "An effect is missing.",
    "suspected": "An effect is suspected: one run shows most of it.",
    "unexplained": "Something is missing that nothing in the catalogue explains.",
}
LARGE: Final = 3.0
"""Times its usual size from which a coefficient is pointed at."""
_HEAD: Final = ("coefficient", "value", "95 %", "usual size", "")
AS_LIKELY: Final = 0.7
"""Odds from which a rival counts as likely as the best set."""


def _none() -> Mapping[str, Any]:
    return MappingProxyType({})


@dataclass(frozen=True, kw_only=True, repr=False)
class Finding(Described):
    """One effect of the best set.

    `coefficients, std`: fitted together with the base and the other effects of the set.
    `value`: grid value of its nonlinear parameter, and `parameter` what that is. `parameter`:
    name and unit; empty where there is none. `log_odds`: ln of the odds for it, beside the
    other effects of the set. `rivals`: effects that mimic it on these runs. `separating_test`:
    what would tell it from others. `error_before, error_after`: held-out error without and with
    it, over the rms force, over all channels; of free-running records that of the heading
    [deg]. `error_level`: the same error if nothing is missing: of noise, run scatter and what
    the others leave unknown; of records of starts, sensors, values and unknown forces.
    `beside`: whether the coefficients are what comes to values that the model has, as
    free-running records tell; captive tests tell the whole of terms that the model lacks.
    `errors`: the same by channel [N, N m]; of free-running records position [m], heading [deg],
    speed [m/s] and yaw rate [deg/s]. `levels`: the level of the noise by channel.
    """

    effect: str
    family: str
    kind: str
    summary: str
    coefficients: Mapping[str, float]
    std: Mapping[str, float]
    typical: Mapping[str, float]
    value: float
    parameter: str
    log_odds: float
    rivals: tuple[str, ...]
    separating_test: str
    error_before: float = math.nan
    error_after: float = math.nan
    error_level: float = math.nan
    beside: bool = False
    errors: Mapping[str, tuple[float, float]] = field(default_factory=_none)
    levels: Mapping[str, float] = field(default_factory=_none)

    @property
    def evidence(self) -> str:
        """Odds in words."""
        return odds(self.log_odds)

    @property
    def channels(self) -> tuple[str, ...]:
        """Channels whose held-out error falls by more than a hundredth."""
        return tuple(name for name, (before, after) in self.errors.items() if after < 0.99 * before)

    @property
    def explained(self) -> dict[str, float]:
        """Share of the held-out mean square error that it takes away, by channel."""
        return {name: _taken(before, after) for name, (before, after) in self.errors.items()}

    def rows(self) -> list[list[str | None]]:
        """Coefficient, value, half of the 95 % interval, usual size, and what is odd about it."""
        rows: list[list[str | None]] = [
            [
                name,
                number(value, 3),
                f"± {number(WIDE * self.std[name], 2)}",
                number(self.typical[name], 2),
                self._odd(name),
            ]
            for name, value in self.coefficients.items()
        ]
        return (
            [*rows, [self.parameter, number(self.value, 3), "", "", ""]] if self.parameter else rows
        )

    def _odd(self, name: str) -> str:
        value, usual = self.coefficients[name], self.typical[name]
        half = WIDE * self.std[name]
        if abs(value) - half > LARGE * abs(usual):
            return "far more than usual"
        # A name in brackets has no sign of its own: it is a harmonic or a place in a table.
        if abs(value) > half and value * usual < 0.0 and "[" not in name:
            return "of the other sign than usual"
        return ""

    @property
    def title(self) -> str:
        """Its name and what it is, on one line."""
        return f"{self.effect}: {self.summary}"

    @property
    def share(self) -> float:
        """Share of the held-out mean square error that it takes away beside the others."""
        return _taken(self.error_before, self.error_after)

    def remarks(self) -> list[str]:
        """How the error of what was left out falls, what resembles it, and what would tell."""
        said = []
        if math.isfinite(self.error_before):
            said.append(f"Error of what was left out: {self._fall()}.")
        if self.rivals:
            said.append(f"On such runs it resembles: {', '.join(self.rivals)}.")
        if self.separating_test:
            said.append(f"To be sure: {self.separating_test}.")
        return said

    def _fall(self) -> str:
        falls = ", ".join(
            f"{name} {before:.3g} to {after:.3g} {UNITS[name]}{self._noise(name)}"
            for name, (before, after) in self.errors.items()
            if name in self.channels
        )
        if "heading" in self.errors:
            return falls or "it does not fall"
        shares = fallen(self.error_before, self.error_after, self.error_level)
        return f"{shares} ({falls})" if falls else f"{shares}; it does not fall"

    def _noise(self, channel: str) -> str:
        return f" with noise of {self.levels[channel]:.3g}" if channel in self.levels else ""

    def _headline(self) -> str:
        return f"{self.effect} ({self.family}): evidence {self.evidence}"

    def _sections(self) -> Sequence[Section]:
        return [replace(_effect(self), title=f"{self.title} Evidence {self.evidence}.")]

    def to_dict(self) -> dict[str, Any]:
        """As plain data, with the names that ``pmmkit diagnose --json`` has."""
        return {
            "effect": self.effect,
            "family": self.family,
            "kind": self.kind,
            "summary": self.summary,
            "channels": list(self.channels),
            "coefficients": dict(self.coefficients),
            "std": dict(self.std),
            "typical": dict(self.typical),
            "parameter": self.parameter,
            "value": self.value,
            "evidence": self.evidence,
            "error_before": self.error_before,
            "error_after": self.error_after,
            "error_level": finite(self.error_level),
            "errors": {
                name: {
                    "before": before,
                    "after": after,
                    "level": self.levels.get(name),
                    "unit": UNITS[name],
                }
                for name, (before, after) in self.errors.items()
            },
            "explained": self.explained,
            "rivals": list(self.rivals),
            "separating_test": self.separating_test,
        }


def _taken(before: float, after: float) -> float:
    """Share of the mean square error that goes."""
    return 1.0 - (after / before) ** 2 if before > 0 else 0.0


ROUNDING: Final = 1e-6
"""ln evidence that is none: a difference of sums that are as large as thousands."""


@dataclass(frozen=True, kw_only=True)
class SuspectRun:
    """An effect that one run decides: where the others do not agree, that run may be wrong.

    `effect, run`: the effect, and the run to repeat. `log_odds`: ln of the odds for it with
    that run. `others`: ln evidence for it without that run, before any price. Of 24 clean campaigns
    with one run that misreads by 6 % the suspected one has -5; of eight effects at .3 of the usual
    size that hang on a sound run five have more than 0, and no other run shows the three others.
    """

    effect: str
    run: str
    log_odds: float
    others: float

    @property
    def agrees(self) -> bool:
        """Whether the other runs speak for the effect too."""
        return self.others > ROUNDING

    def __str__(self) -> str:
        return f"{self.effect} (run {self.run})"


VARIES: Final = 0.25
"""Share of its size by which an effect must differ between tests to be told. Effects at a physical
source, whose form is not quite that of the catalogue, do by up to .21 beyond their intervals."""
CHANCE: Final = 0.01
"""Chance, over all factors of all named effects, that one of one size is said to vary."""


@dataclass(frozen=True, kw_only=True)
class Homogeneity:
    """Sizes of an effect in some tests, over the size that all tests together give.

    `effect, factor`: what may vary over what. `sizes, std`: by level of the factor in words.
    `chance`: that an effect of one size varies so, over all that was asked (Holm).
    """

    effect: str
    factor: str
    sizes: Mapping[str, float]
    std: Mapping[str, float]
    chance: float

    @property
    def varies(self) -> bool:
        """Whether the size is another in some tests, by more than `VARIES` beyond the interval."""
        beyond = (abs(size - 1.0) - WIDE * self.std[x] for x, size in self.sizes.items())
        return self.chance < CHANCE and max(beyond) > VARIES

    def __str__(self) -> str:
        told = ", ".join(f"{size:.2f} {words}" for words, size in self.sizes.items())
        return f"{self.effect} is not constant over {self.factor} (over its size: {told})"


OTHER: Final = 0.05
"""Share by which the errors of a kind of records must change to count as other ones: of HSVA's
zigzags single effects that tell nothing change them by up to .05."""


@dataclass(frozen=True, kw_only=True)
class Transfer:
    """What an effect does to kinds of records, each predicted by all others.

    `changes`: by kind the share by which its errors (position, heading, speed, yaw rate, each
    beside what does not matter of it) change with the effect, beside those before it.
    """

    effect: str
    changes: Mapping[str, float]

    @property
    def is_narrow(self) -> bool:
        """Whether it lowers the errors of one kind of records and raises those of another."""
        values = self.changes.values()
        return self.lowers and max(values, default=0.0) > OTHER

    @property
    def lowers(self) -> bool:
        """Whether it lowers the errors of any kind of records."""
        return min(self.changes.values(), default=0.0) < -OTHER

    def __str__(self) -> str:
        told = [f"{kind} {100 * x:+.0f} %" for kind, x in self.changes.items()]
        words = f"{self.effect} changes the errors of what is left out: {', '.join(told)}"
        if not self.is_narrow:
            return words
        lowered = listed([kind for kind, x in self.changes.items() if x < -OTHER])
        return f"{words}; it holds for this kind of run: {lowered}"

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        return {"effect": self.effect, "changes": dict(self.changes), "narrow": self.is_narrow}


@dataclass(frozen=True, kw_only=True)
class Nearest:
    """The set of effects that comes nearest to something that is not in the catalogue.

    `effects`: the set. It is not named. `error_before, error_after, error_level`: held-out
    error without and with it, and what noise alone gives, over the rms forces; of free-running
    records that of `channel` in its unit. `channel`: channel whose errors stay furthest above
    noise, ``all`` for all of their harmonics. `ratio`: root mean square of these over what noise
    gives.
    """

    effects: tuple[str, ...]
    error_before: float
    error_after: float
    error_level: float
    channel: str
    ratio: float

    def __str__(self) -> str:
        where = "harmonics" if self.channel == "all" else f"errors in {self.channel}"
        if self.channel in (*CHANNELS, "all"):
            what = f"from {fallen(self.error_before, self.error_after, self.error_level)}"
        else:
            where = where.replace("_", " ")
            what = f"from {self.error_before:.3g} to {self.error_after:.3g} {UNITS[self.channel]}"
        return (
            f"The nearest relative is {' and '.join(self.effects)}; do not take it for the cause. "
            f"With it the error of what was left out goes {what}, and {where} stay at "
            f"{self.ratio:.2f} times what noise gives."
        )


def fallen(before: float, after: float, level: float) -> str:
    """Held-out errors over the rms forces before and after, beside the noise level."""
    noise = f", where noise alone gives {100 * level:.2f} %" if math.isfinite(level) else ""
    return f"{100 * before:.2f} % to {100 * after:.2f} % of the rms forces{noise}"


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Diagnosis(Described):
    """The answer, its rivals, and what could not be asked.

    Parameters
    ----------
    verdict : {"noise", "refit", "missing_effect", "suspected", "unexplained"}
        No effect is needed; none, but values of the model are others (free-running records); a set
        of effects is missing; one run alone shows an effect; something is missing, and nothing in
        the catalogue explains it.
    group : tuple of (effects, odds)
        The best set first, with the odds of each against it: these runs cannot tell them apart.
    flags : tuple of str
        Empty, or ``not_the_whole_story`` and the reasons in words: something is left beside the
        best set, or, where nothing is named, beside the base; or ``perhaps_outside`` and how
        probable it is, above 5 %, that the name stands for something outside the catalogue.
    findings : tuple of Finding
        The effects of the best set.
    chance : float
        Probability that no effect at all gives a single effect so good.
    covered : tuple of Visible
        What these runs could show.
    entries : tuple of RankedSet
        All sets that were looked at.
    floor : float
        What counts as too small to matter, over the rms force of a channel.
    base : mapping of str to float
        Derivatives of the base without the effects.
    given : tuple of str
        Effects that the base has already.
    errors : mapping of str to Mapping of str to float
        Errors before and after (free-running records): of records left out one after another, and
        of those held out.
    model : Model, optional
        With the best set, all values fitted together (free-running records).
    refitted : Model, optional
        With its own values fitted and no effect added.
    corrections : mapping of str to float
        What the best set says of current and instruments (free-running records): words of
        `effects.seen.OUTSIDE`, no values of a model.
    notes : tuple of str
        What a reader must know.
    suspected : tuple of SuspectRun
        Effects that one run alone decides.
    nearest : Nearest, optional
        What comes nearest where something is unexplained.
    formula : EmpiricalFormula, optional
        What fits where something is unexplained or flagged (captive tests): numbers, no cause.
    disagreements : tuple of Disagreement
        Groups of runs that disagree with the others beside the answer, or explain as much in its
        place (captive tests).
    homogeneity : tuple of Homogeneity
        Sizes of each named effect by kind of test, speed, side, amplitude and frequency (captive
        tests).
    not_asked : mapping of str to str
        The rest of the catalogue, and why such runs are not asked for it.
    untold : tuple of Untold
        What the runs cannot tell of their own errors, by their settings alone (captive tests).
    outside : Outside, optional
        How probable it is that the answer stands for something outside the catalogue, where its
        entries were hidden in these runs (captive tests).
    transfers : tuple of Transfer
        What each effect of the best set does to kinds of records that are left out (free-running
        records).
    """

    verdict: Verdict
    group: tuple[tuple[tuple[str, ...], float], ...]
    flags: tuple[str, ...]
    findings: tuple[Finding, ...]
    chance: float
    covered: tuple[Visible, ...]
    entries: tuple[RankedSet, ...]
    floor: float
    base: Mapping[str, float]
    given: tuple[str, ...] = ()
    errors: Mapping[str, Mapping[str, float]] = field(default_factory=_none)
    model: Model | None = None
    refitted: Model | None = None
    corrections: Mapping[str, float] = field(default_factory=_none)
    notes: tuple[str, ...] = ()
    suspected: tuple[SuspectRun, ...] = ()
    nearest: Nearest | None = None
    formula: EmpiricalFormula | None = None
    disagreements: tuple[Disagreement, ...] = ()
    homogeneity: tuple[Homogeneity, ...] = ()
    not_asked: Mapping[str, str] = field(default_factory=_none)
    untold: tuple[Untold, ...] = ()
    outside: Outside | None = None
    transfers: tuple[Transfer, ...] = ()

    def beside(self, hidden: HiddenEntries) -> Diagnosis:
        """With what hidden entries say of the answer: a name that may stand for something else is
        flagged."""
        names = self.best or (() if self.nearest is None else self.nearest.effects)
        if not names:
            return self
        rivals = dict.fromkeys(name for own, _ in self.group[1:] for name in own)
        scores = {} if self.flags else {item.effect: item.log_odds for item in self.findings}
        outside = hidden.of(names, tuple(rivals), scores, self.covered)
        flags = (PERHAPS, str(outside)) if outside.doubtful else self.flags
        return replace(self, outside=outside, flags=flags)

    @property
    def best(self) -> tuple[str, ...]:
        """The best set of effects; empty where none is named."""
        return self.group[0][0] if self.group else ()

    @property
    def proposed(self) -> tuple[Finding, ...]:
        """What to add now: of a set that is not the whole story one effect alone, since the others
        may stand for what is asked once it is there: that of the greatest odds, of those that lower
        what is left out if any is known to; none that holds for a kind of records alone."""
        narrow = {item.effect for item in self.transfers if item.is_narrow}
        found = tuple(item for item in self.findings if item.effect not in narrow)
        if not self.flags:
            return found
        lowering = {item.effect for item in self.transfers if item.lowers}
        first = sorted(found, key=lambda item: (item.effect not in lowering, -item.log_odds))
        return tuple(first[:1])

    @property
    def ranked(self) -> tuple[Finding, ...]:
        """The findings, those first that take the largest share of the held-out misfit away."""
        return tuple(sorted(self.findings, key=lambda item: -item.share))

    def weight(self, name: str, share: float = math.nan) -> Weight:
        """Evidence for an effect in words; of one that is not named, `share` of the held-out misfit
        goes with it."""
        return weight_of(name, self.entries, self.best, share)

    def log_odds_of(self, name: str) -> float:
        """ln odds of the best set with an effect against the best one without it."""
        return with_or_without(name, self.entries)

    @property
    def families(self) -> tuple[str, ...]:
        """Families of the best set."""
        return tuple(dict.fromkeys(item.family for item in self.findings))

    @property
    def not_testable(self) -> tuple[Visible, ...]:
        """Effects that these runs cannot show at their usual size, but for those that are named."""
        return tuple(item for item in self.covered if not item.shown and item.name not in self.best)

    @property
    def sentence(self) -> str:
        """The verdict in words."""
        return VERDICTS[self.verdict]

    @property
    def answer(self) -> str:
        """The effects that are named, suspected or nearest, or the verdict, in few words."""
        if self.best:
            return " and ".join(self.best)
        if self.verdict == "suspected":
            return " and ".join(map(str, self.suspected))
        if self.nearest is not None:
            return f"nearest relative {' and '.join(self.nearest.effects)}"
        return self.sentence.rstrip(".").lower()

    def remarks(self) -> list[str]:
        """What is to be said of the findings together."""
        said = []
        if self.given:
            said.append(f"The base has already: {', '.join(self.given)}.")
        if self.findings:
            said.append(f"Family: {', '.join(self.families)}.")
        outside = [] if self.outside is None or self.outside.doubtful else [str(self.outside)]
        if self.flags and self.flags[0] != PERHAPS and self.findings:
            said.append(
                "It is not the whole story: something is left that no named effect explains. "
                "Take it as the nearest relative."
            )
        if self.nearest is not None:
            said.append(str(self.nearest))
        formula = [] if self.formula is None else self.formula.remarks()
        return [*said, *self.flags[1:], *filter(None, outside), *formula]

    def table(self) -> Grid:
        """The coefficients of all findings."""
        groups = [Group(rows=item.rows(), title=self._titled(item)) for item in self.ranked]
        return Grid(head=_HEAD, groups=groups, texts=(4,))

    def error_table(self) -> Grid:
        """Errors before and after of free-running records, a row for each of `errors`."""
        names = list(
            dict.fromkeys(name for row in self.errors.values() for name in row if name in UNITS)
        )
        rows: list[list[str | None]] = [
            [what, *(f"{row[name]:.3g}" if name in row else "-" for name in names)]
            for what, row in self.errors.items()
        ]
        head = [f"{name.replace('_', ' ')} [{UNITS[name]}]" for name in names]
        return Grid(head=["", *head], groups=[Group(rows=rows)])

    def plot(self) -> Figure:
        """Evidence of the best effects and sets, what is named in full colour."""
        from pmmkit.diagnosis.figures import evidence
        from pmmkit.effects import is_fault

        named = [names for names, _ in self.group]
        entries = [item for item in self.entries if len(item.names) == 1 or item.names in named]
        return evidence(
            [item.names for item in entries],
            [item.log_evidence for item in entries],
            named=[item.names in named for item in entries],
            faults=[all(map(is_fault, item.names)) for item in entries],
        )

    def plot_coverage(self) -> Figure:
        """Share of its usual size that each effect could have and hide from these runs."""
        from pmmkit.diagnosis.figures import coverage

        return coverage(
            [item.name for item in self.covered],
            [item.hides for item in self.covered],
            [item.shown for item in self.covered],
        )

    def plot_homogeneity(self) -> Figure:
        """Size of each named effect by kind of test, speed, side, amplitude and frequency."""
        from pmmkit.diagnosis.figures import homogeneity

        return homogeneity(
            [
                (item.effect, item.factor, words, size, WIDE * item.std[words])
                for item in self.homogeneity
                for words, size in item.sizes.items()
            ]
        )

    def _headline(self) -> str:
        rivals = f", {counted(len(self.group) - 1, 'rival')}" if len(self.group) > 1 else ""
        return f"{self.verdict.replace('_', ' ')}: {self.answer}{rivals}"

    def _sections(self) -> Sequence[Section]:
        floor = (
            f"What is smooth and below {100 * self.floor:g} % of a channel's rms force is left "
            f"alone."
        )
        rivals = [f"{' and '.join(names)} ({_against(odds)})" for names, odds in self.group[1:]]
        hidden = [f"{item.name}: {item.why}{_hides(item.hides)}" for item in self.not_testable]
        if self.not_asked:
            hidden.append(
                f"the rest of the catalogue ({len(self.not_asked)}): such runs are not asked for "
                f"it; --json gives the reason of each"
            )
        told = [
            Section(title="These runs cannot tell it from", points=rivals),
            Section(
                title="What each effect does to records of a kind that is left out",
                points=[str(item) for item in self.transfers],
            ),
            Section(title="These runs could not show", points=hidden),
            Section(title="What these runs cannot tell", points=[str(x) for x in self.untold]),
            Section(title="Notes", points=self.notes),
        ]
        return [
            Section(paragraphs=[floor, f"Verdict: {self.sentence}", *self.remarks()]),
            *(replace(_effect(item), title=self._titled(item)) for item in self.ranked),
            *self._formula(),
            *(section for section in told if section.points),
        ]

    def _titled(self, item: Finding) -> str:
        """A finding with its evidence against the sets without it, in words and as odds."""
        words = self.weight(item.effect).capitalize()
        evidence = odds(self.log_odds_of(item.effect))
        return f"{item.title} {words} (evidence {evidence})."

    def _formula(self) -> list[Section]:
        if self.formula is None or not self.formula.terms:
            return []
        return [Section(title="Terms of the formula", tables=[self.formula.table()])]

    def to_pandas(self) -> pd.DataFrame:
        """Every single effect: family, ln evidence (NaN where these runs cannot ask for it), signal
        at usual size, what could hide."""
        import pandas as pd

        single = {item.names[0]: item.log_evidence for item in self.entries if len(item.names) == 1}
        return pd.DataFrame(
            [
                {
                    "effect": item.name,
                    "family": item.family,
                    "log_evidence": single.get(item.name, math.nan),
                    "signal": item.signal,
                    "size_that_could_hide": item.hides,
                    "shown": item.shown,
                    "why": item.why,
                }
                for item in self.covered
            ]
        ).sort_values("log_evidence", ascending=False, ignore_index=True)

    def to_dict(self) -> dict[str, Any]:
        """As plain data: what ``pmmkit diagnose --json`` prints."""
        return {
            "verdict": self.verdict,
            "group": [{"effects": list(names), "odds": odds} for names, odds in self.group],
            "flags": list(self.flags),
            "proposed": [item.effect for item in self.proposed],
            "suspected": [
                {
                    "effect": item.effect,
                    "run": item.run,
                    "evidence": odds(item.log_odds),
                    "others_agree": item.agrees,
                }
                for item in self.suspected
            ],
            "nearest": None if self.nearest is None else asdict(self.nearest),
            "formula": None if self.formula is None else self.formula.to_dict(),
            "disagreements": [asdict(item) for item in self.disagreements],
            "homogeneity": [{**asdict(item), "varies": item.varies} for item in self.homogeneity],
            "findings": [item.to_dict() for item in self.findings],
            "transfers": [item.to_dict() for item in self.transfers],
            "not_testable": [
                *(
                    {"effect": x.name, "why": x.why, "size_that_could_hide": finite(x.hides)}
                    for x in self.not_testable
                ),
                *(
                    {"effect": name, "why": why, "size_that_could_hide": None}
                    for name, why in self.not_asked.items()
                ),
            ],
            "untold": [item.to_dict() for item in self.untold],
            "outside": None if self.outside is None else self.outside.to_dict(),
            "chance": self.chance,
            "floor": self.floor,
            "given": list(self.given),
        }


def _effect(item: Finding) -> Section:
    """A finding as a section of the diagnosis."""
    table = Grid(head=_HEAD, groups=[Group(rows=item.rows())], texts=(4,))
    return Section(title=item.title, points=item.remarks(), tables=[table])


def _against(odds: float) -> str:
    return f"about {1.0 / odds:.0f} to 1 against it" if odds < AS_LIKELY else "as likely"


ANY: Final = 100.0
"""Share of the usual size from which that could hide is no bound that tells anybody anything."""


def _hides(share: float) -> str:
    if not math.isfinite(share):
        return ""
    return f"; {f'up to {share:.2g} of its usual' if share <= ANY else 'any'} size could hide"
