"""From captive tests to a verdict: noise, a missing effect with its rivals, or unexplained."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from pmmkit.conventions import Convention
from pmmkit.diagnosis.base import Base
from pmmkit.diagnosis.build import build
from pmmkit.diagnosis.candidate import Candidate
from pmmkit.diagnosis.contest import Entry, contest, gate
from pmmkit.diagnosis.coverage import Visible, coverage, remainder
from pmmkit.diagnosis.faults import FAULTS, carriage_fault
from pmmkit.diagnosis.physics import PHYSICS
from pmmkit.diagnosis.system import Block, System
from pmmkit.diagnosis.views import views_of
from pmmkit.effects.catalogue import catalogue
from pmmkit.errors import DataError
from pmmkit.model import Model, load_model
from pmmkit.reduction.columns import columns_of
from pmmkit.runs.run import Campaign
from pmmkit.structures import STRUCTURES, Structure, structure_of

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]
Verdict = Literal["noise", "missing_effect", "unexplained"]
CHANCE: Final = 0.01
"""A best effect that chance alone gives more often than this is no finding."""
LEAST: Final = 1.0
"""Least ln evidence of a finding, the price of the catalogue's size taken off."""
RIVALS: Final = math.log(20.0)
"""Sets within these odds of the best cannot be told from it."""
SMOOTH: Final = 3.0
"""ln evidence from which something smooth is left that the answer does not explain."""


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
    evidence : str
        Odds in words.
    rivals : tuple of str
        Effects that mimic it on these runs.
    separating_test : str
        What would tell it from others.
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
    evidence: str
    rivals: tuple[str, ...]
    separating_test: str


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
        ``not_the_whole_story`` where something smooth is left beside the best set.
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
                {"effect": item.name, "family": item.family, "log_evidence": single[item.name],
                 "signal": item.signal, "size_that_could_hide": item.hides, "shown": item.shown,
                 "why": item.why}
                for item in self.covered
            ]
        ).sort_values("log_evidence", ascending=False, ignore_index=True)  # fmt: skip


def diagnose(
    model: Model | str | Path | Sequence[str] | Structure, campaign: Campaign, **settings: Any
) -> Diagnosis:
    """Name what a model lacks that captive tests show.

    Parameters
    ----------
    model : Model, str, path, sequence of str or Structure
        A model, whose derivatives of hull and added mass are the base; the name of a structure, of
        a library ship or a file; or a list of derivatives. The values are fitted to the tests.
    campaign : Campaign
        Captive tests with histories.
    **settings
        As for `diagnose_captive`.

    Returns
    -------
    Diagnosis

    Raises
    ------
    DataError
        If the campaign is free-running.
    """
    if isinstance(model, Structure) or (isinstance(model, str) and model in STRUCTURES):
        return diagnose_captive(campaign, model, **settings)
    if isinstance(model, (str, Path)):
        model = load_model(model)
    if not isinstance(model, Model):
        return diagnose_captive(campaign, model, **settings)
    names = [
        name
        for effect in ("hull_polynomial", "added_mass")
        if effect in model.parts
        for name in model.parts[effect].values
        if catalogue()[effect].parameter(name) is None
    ]
    return diagnose_captive(campaign, names, **settings)


def diagnose_captive(
    campaign: Campaign,
    structure: str | Sequence[str] | Structure = "cubic",
    *,
    floor: float = 0.005,
    candidates: Sequence[Candidate] | None = None,
    seed: int = 0,
) -> Diagnosis:
    """Name the physical effect, or the fault of the measurement, that captive tests show.

    Parameters
    ----------
    campaign : Campaign
        Captive tests with histories.
    structure : str, sequence of str or Structure
        The base: derivatives of one set over all speeds. Rudder and heel runs add their linear
        terms.
    floor : float
        Everything smooth in the motion below this share of the rms force of a channel does not
        matter: the user's uncertainty of the forces beside noise.
    candidates : sequence of Candidate, optional
        Who takes part; by default the whole catalogue of effects and faults.
    seed : int
        Of the draws that calibrate chance.

    Returns
    -------
    Diagnosis

    Raises
    ------
    DataError
        If the campaign is free-running, or holds no run with a known noise.

    Notes
    -----
    Forces of all runs are projected onto means and harmonics, the second cycle apart from later
    ones; whitened by the noise between the harmonics, run scatter of the greatest restricted
    likelihood, and a smooth floor; and the base projected off. Each effect is one block of columns
    over all channels and runs, a fault has one size for all of them; nonlinear parameters are
    averaged over a grid. Sets of up to three effects are ranked by marginal likelihood with prior
    sizes from the catalogue and a price of ln 2K per effect. Nothing is named unless chance gives
    so much evidence in less than 1 % of campaigns without any effect.
    """
    with threadpool_limits(1):
        return _diagnosed(campaign, structure, floor, candidates, seed)


def _diagnosed(
    campaign: Campaign, structure: str | Sequence[str] | Structure, floor: float,
    candidates: Sequence[Candidate] | None, seed: int,
) -> Diagnosis:  # fmt: skip
    """The diagnosis on one thread: the matrices are too small for more."""
    usable = [view for view in views_of(campaign) if view.force]
    if not usable:
        raise DataError(
            "No run states its noise: a diagnosis needs histories of steady or oscillating runs."
        )
    channels = tuple(dict.fromkeys(name for view in usable for name in view.force))
    names = columns_of(structure_of(structure), campaign.runs, channels).required
    speeds = sorted({round(view.speed, 6) for view in usable})
    base = Base(
        names=names, values={}, ship=campaign.ship, water=campaign.water, convention=Convention(),
        reference=float(np.median(speeds)),
    )  # fmt: skip
    every = _contestants(base, speeds) if candidates is None else tuple(candidates)
    system = build(usable, base, every, floor=floor)
    entries = contest(system)
    covered = coverage(system)
    return _answer(system, entries, covered, floor, seed)


def _contestants(base: Base, speeds: Sequence[float]) -> tuple[Candidate, ...]:
    """The catalogue, without what the base has already."""
    known = {name for names in base.names.values() for name in names}
    found = [
        item for item in (*PHYSICS, *FAULTS)
        if not set(item.coefficients) <= known
    ]  # fmt: skip
    if len(speeds) > 1:
        found.append(carriage_fault(tuple(speeds)))
    return tuple(found)


def _answer(
    system: System, entries: Sequence[Entry], covered: tuple[Visible, ...], floor: float, seed: int
) -> Diagnosis:
    singles = [item for item in entries if len(item.names) == 1]
    chance = gate(system, max(item.log_evidence for item in singles), seed=seed)
    best = entries[0]
    named = chance < CHANCE and best.log_evidence > LEAST
    blocks = _blocks(system, best) if named else []
    left = remainder(system, blocks)
    verdict: Verdict = "missing_effect" if named else "noise"
    if not named and left > SMOOTH:
        verdict = "unexplained"
    group = [
        (item.names, math.exp(item.log_evidence - best.log_evidence))
        for item in entries
        if item.log_evidence > best.log_evidence - RIVALS and len(item.names) <= len(best.names)
    ]
    return Diagnosis(
        verdict=verdict, group=tuple(group) if named else (),
        flags=("not_the_whole_story",) if named and left > SMOOTH else (),
        findings=_findings(system, best, blocks, covered) if named else (), chance=chance,
        covered=covered, entries=tuple(entries), floor=floor, base=system.base.values,
    )  # fmt: skip


def _blocks(system: System, entry: Entry) -> list[Block]:
    return [
        next(b for b in system.blocks if b.candidate.name == name and b.value == value)
        for name, value in zip(entry.names, entry.values, strict=True)
    ]


def _findings(
    system: System, entry: Entry, blocks: Sequence[Block], covered: Sequence[Visible]
) -> tuple[Finding, ...]:
    at = np.concatenate([np.arange(b.columns.start, b.columns.stop) for b in blocks])
    G = system.gram[np.ix_(at, at)] + np.eye(len(at))
    covariance = np.linalg.inv(G)
    value = system.centre[at] + covariance @ (
        system.score[at] - system.gram[np.ix_(at, at)] @ system.centre[at]
    )
    value, std = value * system.prior[at], np.sqrt(np.diagonal(covariance)) * system.prior[at]
    visible = {item.name: item for item in covered}
    found, begin = [], 0
    for block in blocks:
        c = block.candidate
        own = slice(begin, begin + c.size)
        begin += block.columns.stop - block.columns.start
        found.append(
            Finding(
                effect=c.name,
                family=c.family,
                kind=c.kind,
                summary=c.summary,
                coefficients=dict(zip(c.coefficients, value[own].tolist(), strict=True)),
                std=dict(zip(c.coefficients, std[own].tolist(), strict=True)),
                typical=dict(zip(c.coefficients, c.typical, strict=True)),
                value=block.value,
                parameter=c.parameter,
                evidence=odds(entry.log_evidence),
                rivals=tuple(visible[c.name].mimics),
                separating_test=c.check,
            )
        )
    return tuple(found)


def odds(log_evidence: float) -> str:
    """ln evidence in words.

    Examples
    --------
    >>> odds(3.0), odds(80.0)
    ('about 20 to 1', 'over 1000 to 1')
    """
    if log_evidence > math.log(1000.0):
        return "over 1000 to 1"
    return f"about {math.exp(log_evidence):.0f} to 1"
