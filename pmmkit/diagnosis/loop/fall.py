"""How the error of what is left out of the fit falls with each effect that is added."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Final

from pmmkit.campaigns import TEST_KINDS
from pmmkit.models import Step
from pmmkit.presentation import Described, Grid, Group, Section, counted

if TYPE_CHECKING:
    import pandas as pd

    from pmmkit.diagnosis.fall_figures import Panel
    from pmmkit.plotting import Figure

BASE: Final = "base"
"""First line of a fall: the model before any step."""
ALL: Final = "all"
"""The group of everything that is left out."""
FALLS: Final = 0.995
"""A step whose error is above this share of the one before does not lower it."""


@dataclass(frozen=True, kw_only=True)
class FallRow:
    """One error of one campaign after one step.

    `step`: ``base``, or the effect that was added. `campaign`: title of the tests. `group`:
    kind of test, or ``all``. `quantity`: what it is an error of: ``force`` (all channels
    together) or a channel of captive tests; ``position``, ``heading``, ``speed`` or
    ``yaw_rate`` of free-running records. `error, level`: root mean square of what is left out,
    and what noise alone gives of it [`unit`]. `unit`: of both: N, N m, m, deg, m/s or deg/s; %
    of the rms force for ``force``. `force`: root mean square of the measured force or moment,
    all kinds of test [`unit`]; NaN where there is no such scale. `better`: share of conditions
    and channels that the step improves; NaN where that is not asked.
    """

    step: str
    campaign: str
    group: str
    quantity: str
    error: float
    level: float
    unit: str
    force: float = math.nan
    better: float = math.nan


@dataclass(frozen=True, kw_only=True)
class ErrorWords:
    """How the errors of one kind of tests are told.

    `of`: the quantity that stands for all of them. `judged`: a step that lowers none of these
    is useless. `left_out`: what is left out: ``conditions`` or ``records``. `total`: its fall
    in words, with a place for it: ``{} of the rms force``. `how`: what was left out, and what
    the numbers are, in a sentence.
    """

    of: str
    judged: tuple[str, ...]
    left_out: str
    total: str
    how: str


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Fall(Described):
    """How the errors of what is left out of the fit fall with each step: one long table, of
    captive tests, of free-running records, or of several campaigns.

    Parameters
    ----------
    added : tuple of Step
        In the order in which they were added.
    rows : tuple of FallRow
        Of each campaign for the base and the steps that it was asked for.
    told : mapping of str to ErrorWords
        By campaign, in their order.
    """

    added: tuple[Step, ...]
    rows: tuple[FallRow, ...]
    told: Mapping[str, ErrorWords]

    @property
    def campaigns(self) -> tuple[str, ...]:
        """Titles of the tests."""
        return tuple(self.told)

    @property
    def steps(self) -> tuple[str, ...]:
        """``base``, then the effects in the order in which they were added, a fault of one of
        several campaigns with the campaign that has it."""
        return (
            BASE,
            *(f"{x.effect} ({x.campaign})" if x.campaign else x.effect for x in self.added),
        )

    @property
    def of(self) -> str:
        """The quantity that stands for all, of the first campaign."""
        return self.told[self.campaigns[0]].of

    @property
    def unit(self) -> str:
        """Of `totals`."""
        return self.units()[self.of]

    @property
    def totals(self) -> tuple[float, ...]:
        """The one error of each step, of the first campaign [`unit`]."""
        return self.errors(self.of)

    @property
    def by_campaign(self) -> dict[str, tuple[float, ...]]:
        """The one error of each step, by campaign."""
        return {name: self.errors(told.of, name) for name, told in self.told.items()}

    @property
    def useless(self) -> tuple[str, ...]:
        """Steps that lower the error of no campaign that was asked for them."""
        return tuple(
            label
            for place, label in enumerate(self.steps[1:], start=1)
            if not any(self._lowers(name, place) for name in self.campaigns)
        )

    @property
    def how(self) -> str:
        """What was left out, and what the numbers are, in sentences."""
        return " ".join(f"{self._title_of(name)}{own.how}" for name, own in self.told.items())

    def errors(
        self, quantity: str, campaign: str | None = None, group: str = ALL
    ) -> tuple[float, ...]:
        """Errors of a quantity after each of `steps`, in its unit.

        Parameters
        ----------
        quantity, campaign, group : str
            As in `FallRow`; the first campaign by default. A step that a campaign is not asked for
            leaves its errors as they are.
        """
        return tuple(row.error for row in self._of(campaign, quantity, group))

    def levels(
        self, quantity: str, campaign: str | None = None, group: str = ALL
    ) -> tuple[float, ...]:
        """What noise alone gives of `errors`."""
        return tuple(row.level for row in self._of(campaign, quantity, group))

    def quantities(self, campaign: str | None = None) -> tuple[str, ...]:
        """What the tests of a campaign can tell an error of."""
        return tuple(row.quantity for row in self._base(campaign) if row.group == ALL)

    def units(self, campaign: str | None = None) -> dict[str, str]:
        """Units of `quantities`."""
        return {row.quantity: row.unit for row in self._base(campaign) if row.group == ALL}

    def groups(self, campaign: str | None = None) -> tuple[str, ...]:
        """Kinds of test that a campaign tells apart."""
        found = dict.fromkeys(row.group for row in self._base(campaign))
        return tuple(name for name in found if name != ALL)

    def asked(self, campaign: str | None = None) -> tuple[bool, ...]:
        """Whether a campaign was asked for the base and each step."""
        name = self._named(campaign)
        there = {row.step for row in self.rows if row.campaign == name}
        mine = [x.effect in there and x.campaign in ("", name) for x in self.added]
        return (True, *mine)

    def only(self, campaign: str) -> Fall:
        """The fall of one of several campaigns, over the steps that it was asked for."""
        mine = zip(self.added, self.asked(campaign)[1:], strict=True)
        return Fall(
            added=tuple(step for step, asked in mine if asked),
            rows=tuple(row for row in self.rows if row.campaign == campaign),
            told={campaign: self.told[campaign]},
        )

    def table(self) -> Grid:
        """A row per step, and a last one of what noise alone gives after it: all errors of one
        campaign; of several one of each, blank where it is not asked for a step."""
        columns = [
            (name, group, self._of(name, quantity, group))
            for name in self.campaigns
            for group, quantity in self._columns(name)
        ]
        asked = {name: self.asked(name) for name in self.campaigns}
        rows = [
            [
                f"+ {label}" if place else label,
                *(
                    _written(own[place].error, own[place].unit) if asked[name][place] else ""
                    for name, _, own in columns
                ),
            ]
            for place, label in enumerate(self.steps)
        ]
        last = [own[-1] for _, _, own in columns]
        if any(math.isfinite(row.level) for row in last):
            levels = (_written(x.level, x.unit) if math.isfinite(x.level) else "" for x in last)
            rows.append(["noise alone", *levels])
        head = [
            f"{self._title_of(name)}{_column(group, own[0].quantity)} [{own[0].unit}]"
            for name, group, own in columns
        ]
        return Grid(head=["after", *head], groups=[Group(rows=rows)])

    def remarks(self) -> list[str]:
        """What each step changes, and which lower no error, by campaign."""
        return [text for name in self.campaigns for text in self._remarks(name)]

    def plot(self) -> Figure:
        """Errors after each step beside what noise alone gives: all of one campaign, one of each
        of several."""
        from pmmkit.diagnosis.fall_figures import fall

        panels = [panel for name in self.campaigns for panel in self._panels(name)]
        return fall(self.steps, panels)

    def to_frame(self) -> pd.DataFrame:
        """The long table: a row per step, campaign, group and quantity, as in `FallRow`."""
        import pandas as pd

        return pd.DataFrame([asdict(row) for row in self.rows])

    def to_pandas(self) -> pd.DataFrame:
        """The errors as ``error_fall.csv`` holds them.

        Of captive tests a row per step, test type (``all`` too) and channel: step, test, channel,
        error, noise level and force [N, N m], share (error over the force), better (share of
        conditions and channels that a step improves, ``all`` only). Of records a row per step: its
        errors [m, deg, m/s, deg/s], and what noise alone gives of them after the last step
        (``position_level`` …). Both with the campaign.
        """
        import pandas as pd

        found = [
            pd.DataFrame(self._by_channel(name) if self._scaled(name) else self._by_step(name))
            for name in self.campaigns
        ]
        return pd.concat(found, ignore_index=True)

    def _by_channel(self, name: str) -> list[dict[str, object]]:
        """Rows of captive tests, as in the file."""
        of = self.told[name].of
        return [
            {
                "step": row.step,
                "test": row.group,
                "channel": row.quantity,
                "error": row.error,
                "level": row.level,
                "force": row.force,
                "share": row.error / row.force if row.force else math.nan,
                "better": row.better,
                "campaign": name,
            }
            for row in self.rows
            if row.campaign == name and row.quantity != of
        ]

    def _by_step(self, name: str) -> list[dict[str, object]]:
        """Rows of records, as in the file."""
        rows: dict[str, dict[str, object]] = {}
        for row in self.rows:
            if row.campaign == name:
                own = rows.setdefault(row.step, {"step": row.step})
                own[row.quantity] = row.error
                own[f"{row.quantity}_level"] = row.level
        names = self.told[name].judged
        head = ("step", *names, *(f"{x}_level" for x in names))
        return [
            {**{x: own.get(x, math.nan) for x in head}, "campaign": name} for own in rows.values()
        ]

    def _scaled(self, name: str) -> bool:
        """Whether the errors of a campaign have a scale: the measured forces."""
        return any(math.isfinite(row.force) for row in self._base(name))

    @cached_property
    def _places(self) -> dict[tuple[str, str, str, str], FallRow]:
        """Rows by campaign, step, group and quantity."""
        return {(x.campaign, x.step, x.group, x.quantity): x for x in self.rows}

    def _named(self, campaign: str | None) -> str:
        return self.campaigns[0] if campaign is None else campaign

    def _base(self, campaign: str | None) -> list[FallRow]:
        """Rows of a campaign before any step."""
        name = self._named(campaign)
        return [row for row in self.rows if (row.campaign, row.step) == (name, BASE)]

    def _of(self, campaign: str | None, quantity: str, group: str = ALL) -> list[FallRow]:
        """The rows that tell of a quantity after each of `steps`."""
        name = self._named(campaign)
        found: list[FallRow] = []
        every = (BASE, *(step.effect for step in self.added))
        for step, asked in zip(every, self.asked(name), strict=True):
            found.append(self._places[name, step, group, quantity] if asked else found[-1])
        return found

    def _lowers(self, name: str, place: int) -> bool:
        """Whether a step lowers an error of a campaign that was asked for it."""
        judged = [x for x in self.told[name].judged if x in self.quantities(name)]
        errors = [self.errors(quantity, name) for quantity in judged]
        return self.asked(name)[place] and any(x[place] <= FALLS * x[place - 1] for x in errors)

    def _title_of(self, name: str) -> str:
        """What stands before what is said of one of several campaigns."""
        return f"{name}: " if len(self.told) > 1 else ""

    def _columns(self, name: str) -> list[tuple[str, str]]:
        """Group and quantity of each column of the table."""
        of = self.told[name].of
        if len(self.told) > 1:
            return [(ALL, of)]
        every = [(ALL, quantity) for quantity in self.quantities(name)]
        return [*every, *((group, of) for group in self.groups(name))]

    def _remarks(self, name: str) -> list[str]:
        told, title = self.told[name], self._title_of(name)
        said, useless = [], []
        for place, (label, asked) in enumerate(zip(self.steps, self.asked(name), strict=True)):
            if place == 0 or not asked:
                continue
            changes = [
                f"{x.replace('_', ' ')} {100 * (errors[place] / errors[place - 1] - 1):+z.0f} %"
                for x in self.quantities(name)
                if (errors := self.errors(x, name))[place - 1] > 0.0
            ]
            share = self._of(name, told.of)[place].better
            better = f"better in {100 * share:.0f} % of the {told.left_out} and channels it changes"
            ends = f"; {better}." if math.isfinite(share) else "."
            said.append(f"{title}{label}: {', '.join(changes)}{ends}")
            if not self._lowers(name, place):
                useless.append(f"{title}{label} lowers no error of left-out {told.left_out}.")
        return said + useless

    def _panels(self, name: str) -> list[Panel]:
        """Of several campaigns one each; of one its channels, kinds of test or kinds of error."""
        from pmmkit.diagnosis.fall_figures import Bars, Panel

        of, left_out = self.told[name].of, self.told[name].left_out

        def bars(quantity: str, group: str, label: str, scale: float = 1.0) -> Bars:
            return Bars(
                label=label,
                errors=tuple(scale * x for x in self.errors(quantity, name, group)),
                level=scale * self.levels(quantity, name, group)[-1],
            )

        base = {x.quantity: x for x in self._base(name) if x.group == ALL}
        channels = [x for x in base.values() if x.force > 0.0]
        if len(self.told) > 1 or not channels:
            shown = [of] if len(self.told) > 1 else list(base)
            return [
                Panel(
                    title=f"{self._title_of(name)}{quantity.replace('_', ' ')}",
                    scale=f"error [{base[quantity].unit}]",
                    bars=(bars(quantity, ALL, ""),),
                )
                for quantity in shown
            ]
        return [
            Panel(
                title="by channel",
                scale=f"error of left-out {left_out},\n% of the channel's rms force",
                bars=tuple(
                    bars(
                        x.quantity,
                        ALL,
                        f"{x.quantity}\n{_ends(self.errors(x.quantity, name))} {x.unit}",
                        100.0 / x.force,
                    )
                    for x in channels
                ),
            ),
            Panel(
                title="by test type, root mean square of the channels",
                bars=tuple(bars(of, x, x.replace("_", "\n")) for x in self.groups(name)),
            ),
        ]

    def _headline(self) -> str:
        ends = []
        for name, told in self.told.items():
            errors, unit = self.errors(told.of, name), self.units(name)[told.of]
            texts = dict.fromkeys(_with_unit(x, unit) for x in (errors[0], errors[-1]))
            ends.append(f"{self._title_of(name)}{told.total.format(' to '.join(texts))}")
        return f"{', '.join(ends)} after {counted(len(self.added), 'step')}"

    def _sections(self) -> Sequence[Section]:
        left_out = dict.fromkeys(told.left_out for told in self.told.values())
        title = f"Error of {' and '.join(left_out)} left out of the fit"
        said = [Section(points=self.remarks())] if self.remarks() else []
        return [Section(title=title, tables=[self.table()]), *said]


def _column(group: str, quantity: str) -> str:
    return quantity.replace("_", " ") if group == ALL else TEST_KINDS[group].title


def _written(value: float, unit: str) -> str:
    return f"{value:.2f}" if unit == "%" else f"{value:.3g}"


def _with_unit(value: float, unit: str) -> str:
    return f"{_written(value, unit)}{'°' if unit == 'deg' else f' {unit}'}"


def _ends(errors: Sequence[float]) -> str:
    ends = [errors[0], *errors[1:][-1:]]
    return " → ".join(f"{x:.3g}" for x in ends)
