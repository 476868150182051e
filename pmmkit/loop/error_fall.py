"""How the held-out error falls with each effect that is added."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from pmmkit.campaigns.test_kinds.registry import kind_of
from pmmkit.channels import CHANNEL_UNITS
from pmmkit.diagnosis.captive.held_out import HeldOut
from pmmkit.loop.evidence import FALLS
from pmmkit.presentation import Described, Grid, Group, Section, counted

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class ErrorFall(Described):
    """How the held-out error falls with each step.

    Parameters
    ----------
    steps : tuple of str
        ``base``, then the effects in the order in which they were added.
    errors : tuple of HeldOut
        After each.
    """

    steps: tuple[str, ...]
    errors: tuple[HeldOut, ...]

    @property
    def totals(self) -> tuple[float, ...]:
        """Error over the rms force, all channels and conditions [%]."""
        return tuple(100.0 * item.share() for item in self.errors)

    @property
    def unit(self) -> str:
        """Of `totals`."""
        return "%"

    @property
    def of(self) -> str:
        """What `totals` are errors of."""
        return "force"

    @property
    def useless(self) -> tuple[str, ...]:
        """Steps that do not lower the held-out error."""
        shares = [item.share() for item in self.errors]
        return tuple(
            name
            for name, before, after in zip(self.steps[1:], shares, shares[1:], strict=False)
            if after > FALLS * before
        )

    @property
    def how(self) -> str:
        """What was left out, and what the numbers are, in a sentence."""
        return (
            "Each condition was left out of the fit in turn, with its repeats, and predicted from "
            "all others: root mean square of the error in newtons and in per cent of the channel's "
            "rms force, beside what noise alone gives."
        )

    def plot(self) -> Figure:
        """Held-out error after each step: by channel, and by test type."""
        from pmmkit.plotting.diagnosis import error_fall

        first = self.errors[0]
        after = [item.of_channel() for item in self.errors]
        return error_fall(
            self.steps,
            {name: [own[name] for own in after] for name in first.channels},
            first.of_channel(kind="force"),
            {test: [item.share(test) for item in self.errors] for test in self.tests},
        )

    @property
    def tests(self) -> tuple[str, ...]:
        """Kinds of test that were left out and predicted."""
        return tuple(dict.fromkeys(self.errors[0].tests))

    def table(self) -> Grid:
        """A row per step: error in per cent of the rms force and what noise alone gives, by channel
        [N, N m], by test."""
        channels = self.errors[0].channels
        rows = []
        for number, (step, item) in enumerate(zip(self.steps, self.errors, strict=True)):
            own = item.of_channel()
            rows.append(
                [
                    f"+ {step}" if number else step,
                    f"{100 * item.share():.2f}",
                    f"{100 * item.share(kind='level'):.2f}",
                    *(f"{own[name]:.3g}" for name in channels),
                    *(f"{100 * item.share(test):.2f}" for test in self.tests),
                ]
            )
        units = [f"{name} [{CHANNEL_UNITS[name]}]" for name in channels]
        tests = [f"{kind_of(test).title} [%]" for test in self.tests]
        return Grid(
            head=["after", "all [%]", "noise [%]", *units, *tests], groups=[Group(rows=rows)]
        )

    def remarks(self) -> list[str]:
        """How much each step makes better, and which do not lower the error."""
        said = []
        for before, step, item in zip(self.errors, self.steps[1:], self.errors[1:], strict=False):
            better = 100 * item.better_than(before)
            said.append(
                f"{step}: better in {better:.0f} % of the conditions and channels it changes."
            )
        return said + [
            f"{step} does not lower the error of left-out conditions." for step in self.useless
        ]

    def _headline(self) -> str:
        ends = [f"{100 * item.share():.2f} %" for item in (self.errors[0], self.errors[-1])]
        return (
            f"{' to '.join(dict.fromkeys(ends))} of the rms force after "
            f"{counted(len(self.steps) - 1, 'step')}"
        )

    def _sections(self) -> Sequence[Section]:
        what = "Error of conditions left out of the fit, over the rms force"
        said = [Section(points=self.remarks())] if self.remarks() else []
        return [Section(title=what, tables=[self.table()]), *said]

    def to_pandas(self) -> pd.DataFrame:
        """A row per step, test type (``all`` too) and channel.

        Columns: step, test, channel, error, noise level and force [N, N m], share (error over the
        force), better (share of conditions and channels that a step improves, ``all`` only).
        """
        import pandas as pd

        rows = []
        for number, (name, item) in enumerate(zip(self.steps, self.errors, strict=True)):
            better = item.better_than(self.errors[number - 1]) if number else float("nan")
            whole = item.of_channel(kind="force")
            for test in (None, *dict.fromkeys(item.tests)):
                errors, levels = item.of_channel(test), item.of_channel(test, kind="level")
                rows += [
                    {
                        "step": name,
                        "test": test or "all",
                        "channel": channel,
                        "error": error,
                        "level": levels[channel],
                        "force": whole[channel],
                        "share": error / whole[channel] if whole[channel] else float("nan"),
                        "better": better if test is None else float("nan"),
                    }
                    for channel, error in errors.items()
                ]
        return pd.DataFrame(rows)
