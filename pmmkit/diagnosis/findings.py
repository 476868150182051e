"""What a diagnosis says: verdict, group of rivals, findings with their evidence, coverage."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, Literal

from pmmkit.channels import CHANNEL_UNITS
from pmmkit.diagnosis.evidence import Entry, Visible
from pmmkit.models import Model
from pmmkit.models.step import odds

if TYPE_CHECKING:
    import pandas as pd

UNITS: Final[Mapping[str, str]] = CHANNEL_UNITS | {"heading": "deg"}
"""Of the errors: forces and moments, or heading and speed of free-running records."""
Verdict = Literal["noise", "missing_effect", "unexplained"]


def _none() -> Mapping[str, Any]:
    return MappingProxyType({})


@dataclass(frozen=True, kw_only=True)
class Finding:
    """One effect of the best set.

    Parameters
    ----------
    effect, family, kind, summary : str
        What it is.
    coefficients, std : mapping of str to float
        Fitted together with the base and the other effects of the set.
    typical : mapping of str to float
        Usual sizes.
    value : float
        Grid value of its nonlinear parameter, and `parameter` what that is.
    parameter : str
        Name and unit; empty where there is none.
    log_odds : float
        ln of the odds for it.
    rivals : tuple of str
        Effects that mimic it on these runs.
    separating_test : str
        What would tell it from others.
    error_before, error_after : float
        Held-out error without and with it, over the rms force, over all channels; of free-running
        records that of the heading [deg].
    errors : mapping of channel to (before, after)
        The same by channel [N, N m]; of free-running records heading [deg] and speed [m/s].
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
    errors: Mapping[str, tuple[float, float]] = field(default_factory=_none)

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
        return {
            name: 1.0 - (after / before) ** 2 if before > 0 else 0.0
            for name, (before, after) in self.errors.items()
        }

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
            "errors": {
                name: {"before": before, "after": after, "unit": UNITS[name]}
                for name, (before, after) in self.errors.items()
            },
            "explained": self.explained,
            "rivals": list(self.rivals),
            "separating_test": self.separating_test,
        }


@dataclass(frozen=True, kw_only=True, eq=False)
class Diagnosis:
    """The answer, its rivals, and what could not be asked.

    Parameters
    ----------
    verdict : {"noise", "missing_effect", "unexplained"}
        No effect is needed; a set of effects is missing; something is, and it is not in the
        catalogue.
    group : tuple of (effects, odds)
        The best set first, with the odds of each against it: these runs cannot tell them apart.
    flags : tuple of str
        Empty, or ``not_the_whole_story`` and the reasons in words: something is left beside the
        best set, or, where nothing is named, beside the base.
    findings : tuple of Finding
        The effects of the best set.
    chance : float
        Probability that no effect at all gives a single effect so good.
    covered : tuple of Visible
        What these runs could show.
    entries : tuple of Entry
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
    current : (float, float)
        Current of the best set where it holds one, to north and east [m/s]; no value of a model.
    rudder_zero : float
        The same of the rudder's zero [rad].
    notes : tuple of str
        What a reader must know.
    """

    verdict: Verdict
    group: tuple[tuple[tuple[str, ...], float], ...]
    flags: tuple[str, ...]
    findings: tuple[Finding, ...]
    chance: float
    covered: tuple[Visible, ...]
    entries: tuple[Entry, ...]
    floor: float
    base: Mapping[str, float]
    given: tuple[str, ...] = ()
    errors: Mapping[str, Mapping[str, float]] = field(default_factory=_none)
    model: Model | None = None
    refitted: Model | None = None
    current: tuple[float, float] = (0.0, 0.0)
    rudder_zero: float = 0.0
    notes: tuple[str, ...] = ()

    @property
    def best(self) -> tuple[str, ...]:
        """The best set of effects; empty where none is named."""
        return self.group[0][0] if self.group else ()

    @property
    def families(self) -> tuple[str, ...]:
        """Families of the best set."""
        return tuple(dict.fromkeys(item.family for item in self.findings))

    @property
    def not_testable(self) -> tuple[Visible, ...]:
        """Effects that these runs cannot show."""
        return tuple(item for item in self.covered if not item.shown)

    def to_pandas(self) -> pd.DataFrame:
        """Every single effect: family, ln evidence, signal at usual size, what could hide."""
        import pandas as pd

        single = {item.names[0]: item.log_evidence for item in self.entries if len(item.names) == 1}
        return pd.DataFrame(
            [
                {
                    "effect": item.name,
                    "family": item.family,
                    "log_evidence": single[item.name],
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
            "findings": [item.to_dict() for item in self.findings],
            "not_testable": [
                {
                    "effect": item.name,
                    "why": item.why,
                    "size_that_could_hide": item.hides if math.isfinite(item.hides) else None,
                }
                for item in self.not_testable
            ],
            "chance": self.chance,
            "floor": self.floor,
            "given": list(self.given),
        }
