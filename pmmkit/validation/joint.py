"""A model beside the tests of one campaign, or of several: each by itself, and all together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, overload

from pmmkit.base import DataError, Progress
from pmmkit.campaigns import Campaign
from pmmkit.models import Model, load_model
from pmmkit.presentation import Described, Grid, Group, Section, number, percent
from pmmkit.reduction import FLOOR, View
from pmmkit.validation.comparison import Comparison, compare_one
from pmmkit.validation.statistics import STATISTICS, together

if TYPE_CHECKING:
    import pandas as pd

ALL: Final = "all"
"""What stands in the place of a campaign where all are meant."""


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class JointComparison(Described):
    """A model beside the tests of several campaigns.

    Parameters
    ----------
    each : mapping of str to Comparison
        By the name of the campaign.
    """

    each: Mapping[str, Comparison]

    def to_pandas(self) -> pd.DataFrame:
        """The rows of all comparisons, each with the name of its campaign: column `campaign`."""
        import pandas as pd

        made = {name: item.to_pandas() for name, item in self.each.items()}
        return pd.concat(made, names=["campaign"]).reset_index("campaign").reset_index(drop=True)

    def joint(self) -> pd.DataFrame:
        """A row per channel and campaign, and one for `all` campaigns where several have it.

        Sizes are shares of what the campaign measured in the channel (rms over its runs), so that
        models of two scales, forces of a towed ship and those of a free one stand in one table:
        channel, campaign, runs, error, bias, uncertainty, ratio (error over uncertainty) and
        within (runs whose error is less). Every run counts alike.
        """
        import pandas as pd

        channels: dict[str, dict[str, list[dict[str, Any]]]] = {}
        for name, item in self.each.items():
            for row in item.rows():
                channels.setdefault(row["channel"], {}).setdefault(name, []).append(row)
        rows = []
        for channel, found in channels.items():
            own = {name: _as_shares(group) for name, group in found.items()}
            if len(own) > 1:
                own[ALL] = [row for group in own.values() for row in group]
            rows += [
                {"channel": channel, "campaign": name, "runs": len(group), **together(group)}
                for name, group in own.items()
            ]
        return pd.DataFrame(rows).drop(columns=["measured", "relative"], errors="ignore")

    def to_dict(self) -> dict[str, Any]:
        """As plain data: what ``pmmkit compare --json`` prints of several campaigns."""
        return {
            "model": next(iter(self.each.values())).model,
            "joint": self.joint().to_dict("records"),
            "campaigns": {name: item.to_dict() for name, item in self.each.items()},
        }

    def _headline(self) -> str:
        return "; ".join(item._headline() for item in self.each.values())

    def _sections(self) -> Sequence[Section]:
        rows = [
            [
                row["channel"].replace("_", " "),
                row["campaign"],
                str(row["runs"]),
                percent(row["error"], signed=False),
                percent(row["bias"]),
                percent(row["uncertainty"], signed=False),
                number(row["ratio"], 3),
                f"{row['within']} of {row['runs']}",
            ]
            for row in self.joint().to_dict("records")
        ]
        head = ["channel", "campaign", "runs", "error", "mean error", "uncertainty"]
        head += ["over uncertainty", "within it"]
        joint = Section(
            title="All campaigns, over what each measured in the channel; every run counts alike",
            tables=[Grid(head=head, groups=[Group(rows=rows)])],
        )
        own = [
            replace(section, title=f"{name}: {section.title}" if section.title else name)
            for name, item in self.each.items()
            for section in item.sections()
        ]
        return [joint, *own]


def _as_shares(rows: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Rows of a channel with sizes over what was measured in it; NaN where that is nothing."""
    size = together(rows)["measured"] or float("nan")
    sizes = [item.name for item in STATISTICS]
    return [{**row, **{name: row[name] / size for name in sizes}} for row in rows]


@overload
def compare(
    model: Model | str | Path,
    campaign: Campaign,
    *,
    floor: float = ...,
    window: float | None = ...,
    extrapolate: bool = ...,
    views: Sequence[View] | None = ...,
    progress: Progress | None = ...,
) -> Comparison: ...


@overload
def compare(
    model: Model | str | Path,
    campaign: Sequence[Campaign] | Mapping[str, Campaign],
    *,
    floor: float = ...,
    window: float | None = ...,
    extrapolate: bool = ...,
    progress: Progress | None = ...,
) -> JointComparison: ...


def compare(
    model: Model | str | Path,
    campaign: Campaign | Sequence[Campaign] | Mapping[str, Campaign],
    *,
    floor: float = FLOOR,
    window: float | None = None,
    extrapolate: bool = False,
    views: Sequence[View] | None = None,
    progress: Progress | None = None,
) -> Comparison | JointComparison:
    """A model beside measurements, and where it fails.

    Parameters
    ----------
    model : Model, str or path
        A model, the name of a library ship, or a file; at any scale: it is brought to that of the
        tests by Froude's law.
    campaign : Campaign, or sequence or mapping of str to these
        One, or several of one ship, by name if a mapping. Captive tests: forces are predicted on
        the measured motion. Free-running tests: the motion is simulated from the measured start
        with the measured rudder and revolutions.
    floor : float
        Share of the rms force of a channel that counts as uncertain whatever else is known.
    window : float, optional
        Free-running: length of the windows that are predicted [s]; 15 ship lengths by default.
    extrapolate : bool
        Allow speeds outside the range of the model's values.
    views : sequence of View, optional
        Captive tests: what `observed` says of them, where several models stand beside the same
        tests.
    progress : callable, optional
        Told what is being done.

    Returns
    -------
    Comparison
        Of several campaigns a `JointComparison`, which has one of each.

    Raises
    ------
    ModelError
        If the model is of another ship than the tests.
    DataError
        If nothing can be compared, with the reasons.

    Notes
    -----
    The comparison error E is predicted less measured. Its validation uncertainty (ASME V&V 20,
    ITTC 7.5-03-01-01) is twice the root of the sum of squares of: the noise of the mean or
    harmonic, by the record's own spectrum; the scatter of repeated runs; the campaign's stated
    uncertainties; that of the model's derivatives; the numerical uncertainty U_SN; and the floor.
    Where E is less, nothing can be said.
    """
    if not 0.0 <= floor < 1.0:
        raise DataError(f"The floor is a share of the force such as 0.005, not {floor:g}.")
    known = model if isinstance(model, Model) else load_model(model)
    one = partial(
        compare_one, known, floor=floor, window=window, extrapolate=extrapolate, progress=progress
    )
    if isinstance(campaign, Campaign):
        return one(campaign, views=views)
    several = campaign if isinstance(campaign, Mapping) else Campaign.by_title(campaign)
    if not several:
        raise DataError("There is no campaign to compare with.")
    return JointComparison(
        each=MappingProxyType({name: one(tests) for name, tests in several.items()})
    )
