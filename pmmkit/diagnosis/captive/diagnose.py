"""From captive tests to a verdict: noise, a missing effect with its rivals, or unexplained."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np

from pmmkit.base import DataError, Problem, Progress, Workers
from pmmkit.campaigns import Campaign
from pmmkit.conventions import STRUCTURES, Convention, Structure, parse_derivative
from pmmkit.diagnosis.captive.base import CaptiveBase
from pmmkit.diagnosis.captive.build import build
from pmmkit.diagnosis.captive.candidate import Candidate, candidate_of
from pmmkit.diagnosis.captive.formula import answer_with_formula
from pmmkit.diagnosis.captive.hidden_entries import OutsideCheck
from pmmkit.diagnosis.captive.refit import effects_of, eligible
from pmmkit.diagnosis.captive.system import LEAST, System, scale_of
from pmmkit.diagnosis.findings import Diagnosis
from pmmkit.effects import CATALOGUE, Effect
from pmmkit.intake import Untold
from pmmkit.models import Model, load_model
from pmmkit.numerics import one_thread
from pmmkit.reduction import FLOOR, View, columns_of

FLOOR_LEAST: Final = 0.001
"""Least floor of forces whose numerical uncertainty is stated."""


def derivatives_of(
    model: Model | str | Path | Sequence[str] | Structure,
) -> tuple[
    Model | str | tuple[str, ...] | Structure, str | tuple[str, ...] | Structure, tuple[str, ...]
]:
    """What a model, a structure or a list of derivatives gives as base of a diagnosis."""
    if isinstance(model, Structure) or (isinstance(model, str) and model in STRUCTURES):
        return model, model, ()
    if isinstance(model, (str, Path)):
        model = load_model(model)
    if not isinstance(model, Model):
        return tuple(model), tuple(model), ()
    return model, model.derivatives, effects_of(model)


def diagnose_captive(
    campaign: Campaign,
    structure: str | Sequence[str] | Structure = "cubic",
    *,
    floor: float | None = None,
    candidates: Sequence[Candidate | Effect] | None = None,
    given: Sequence[str] = (),
    noise: float | None = None,
    own: Sequence[Effect] = (),
    seed: int = 0,
    executor: Workers = None,
    model: Model | None = None,
    outside: bool = False,
    progress: Progress | None = None,
) -> Diagnosis:
    """Name the physical effect, or the fault of the measurement, that captive tests show.

    Notes
    -----
    Forces of all runs are projected onto means and harmonics, the second cycle apart from later
    ones; whitened by the noise between the harmonics, run scatter of the greatest restricted
    likelihood, and a smooth floor; and the base projected off. Each effect is one block of columns
    over all channels and runs, a fault has one size for all of them; nonlinear parameters are
    averaged over a grid. Sets of up to three effects are ranked by marginal likelihood with prior
    sizes from the catalogue and odds of 1 to 80 for each before any test. Nothing is named unless
    chance gives so much evidence in less than 1 % of campaigns without any effect. Where nothing of
    the catalogue explains what is left, products of the motion for which ``model`` has a place are
    asked for a formula.

    With ``outside`` each entry of the catalogue is taken out in turn and hidden in these runs (a
    minute for fifty of them, told to ``progress``): how often a name stands for something else is
    kept in ``hidden_entries.json`` beside the campaign, and told of every name from then on.
    """
    system = captive_system(
        campaign,
        structure,
        floor=floor,
        candidates=candidates,
        noise=noise,
        own=own,
        executor=executor,
    )
    known = system.taking_part(given)
    whole, source = system.whole(known), model or structure
    found = answer_with_formula(whole, known, floor=system.floor, seed=seed, source=source)
    check = OutsideCheck.beside(campaign.folder, made=outside, executor=executor, progress=progress)
    found = check.judged(found, whole, known, source)
    return replace(
        found, untold=Untold.of(campaign.within_reach(), values=found.base, recorded=True)
    )


def captive_system(
    campaign: Campaign,
    structure: str | Sequence[str] | Structure = "cubic",
    *,
    floor: float | None = None,
    candidates: Sequence[Candidate | Effect] | None = None,
    noise: float | None = None,
    own: Sequence[Effect] = (),
    executor: Workers = None,
) -> System:
    """Runs, base and candidates, ready to be asked more than once."""
    campaign = campaign.within_reach()
    usable = _usable(View.of(campaign, unknown_noise=True, executor=executor), noise)
    channels = tuple(dict.fromkeys(name for view in usable for name in view.force))
    names = columns_of(Structure.meant_by(structure), campaign.runs, channels).required
    if "X" in names and any(np.any(view.motion.thrust) for view in usable):
        names = {**names, "X": tuple(dict.fromkeys((*names["X"], "XT")))}
    speeds = sorted({round(view.speed, 6) for view in usable})
    base = CaptiveBase(
        names=names,
        values={},
        ship=campaign.ship,
        water=campaign.water,
        convention=Convention(),
        reference=float(np.median(speeds)),
    )
    if candidates is None:
        every = eligible(base, speeds, own)
        held = base.excited(usable)
        asked = [item for item in every if held.issuperset(item.excites)]
    else:
        mine = [item if isinstance(item, Candidate) else candidate_of(item) for item in candidates]
        every = (*mine, *(candidate_of(item, speeds) for item in own), *_drawn(mine, base, speeds))
        asked = list(every)
    with one_thread():
        system = build(usable, base, asked, floor=floor_for(campaign, usable, floor))
    return replace(system, unasked=tuple(item for item in every if item not in asked))


def standing(
    system: System, names: Sequence[str], own: Sequence[Effect] = ()
) -> tuple[System, tuple[str, ...]]:
    """A system about its base as a model stands that was written with some effects."""
    known = {**CATALOGUE, **{item.name: item for item in own}}
    brought = [known[x] for x in dict.fromkeys(names) if x in known and derivatives_in(known[x])]
    taken = {effect.name for effect in brought}
    rest = tuple(x for x in dict.fromkeys(names) if x not in taken)
    return (with_derivatives(system, brought) if brought else system), rest


def with_derivatives(system: System, effects: Sequence[Effect]) -> System:
    """A system whose base has the derivatives of some effects as its own, as a model that was
    written with them has: fitted freely, and part of what the base expects.
    """
    names = {channel: list(own) for channel, own in system.base.names.items()}
    for name in (x for effect in effects for x in derivatives_in(effect)):
        own = names.setdefault(parse_derivative(name).channel, [])
        own += [name] if name not in own else []
    base = replace(
        system.base, names={channel: tuple(own) for channel, own in names.items()}, values={}
    )
    taken = {effect.name for effect in effects}
    known = {name for own in names.values() for name in own}
    blocks = [block.candidate for block in system.blocks if not block.candidate.partial]
    asked, unasked = (
        [x for x in every if x.name not in taken and not known.issuperset(x.coefficients)]
        for every in ({item.name: item for item in blocks}.values(), system.unasked)
    )
    with one_thread():
        made = build(system.views, base, asked, floor=system.floor)
    return replace(made, unasked=tuple(unasked))


def derivatives_in(effect: Effect) -> tuple[str, ...]:
    """The derivatives that an effect gives to a model; none where it changes them with the speed,
    or is a part of its own."""
    if effect.kind != "terms" or effect.varies_with_speed:
        return ()
    return tuple(effect.sizes({}))


def _drawn(
    given: Sequence[Candidate], base: CaptiveBase, speeds: Sequence[float]
) -> tuple[Candidate, ...]:
    """What every run draws for itself takes part whoever else does."""
    names = {item.name for item in given}
    return tuple(
        item for item in eligible(base, speeds) if item.each_run and item.name not in names
    )


def floor_for(campaign: Campaign, views: Sequence[View], floor: float | None) -> float:
    """What is smooth and too small to matter: as stated, else U_SN, else 0.5 % of measured
    forces."""
    if floor is not None:
        return floor
    scale = _scales(views)
    middle = float(np.median([view.speed for view in views])) ** 2
    shares = [size / (scale[c] * middle) for c, size in campaign.numerical.items() if c in scale]
    if shares:
        return max(*shares, FLOOR_LEAST)
    noise = [
        float(np.sqrt(np.mean(np.diagonal(V)))) / (scale[name] * view.speed**2)
        for view in views
        for name, V in view.covariance.items()
        if name in scale
    ]
    if campaign.computed or float(np.median(noise)) < LEAST:
        raise DataError(
            Problem(
                message="These forces have no noise of their own (CFD): every small difference "
                "would be evidence.",
                remedy="State what they are uncertain by: U_SN = { X = …, Y = …, N = … } under "
                "[cfd] from a grid study or from cycle to cycle, or floor = 0.02 of the rms force "
                "(--floor 0.02).",
            )
        )
    return FLOOR


def _scales(views: Sequence[View]) -> dict[str, float]:
    """Root mean square of the force over U² by channel."""
    names = dict.fromkeys(name for view in views for name in view.force)
    return {name: scale_of(name, views) for name in names}


def _usable(views: Sequence[View], noise: float | None) -> list[View]:
    """Views whose noise is known, or is stated here."""
    if noise is None:
        kept = [_with_known(view) for view in views]
        if found := [view for view in kept if view.force]:
            return found
        raise DataError(
            Problem(
                message="No run states its noise, so nothing can be said of what is beyond it.",
                remedy="Give histories or repeats (repeat_of), state [uncertainty] Y_gauge … or "
                "[cfd] U_SN in the campaign file, or state the uncertainty of a mean or harmonic "
                "yourself: noise = 0.01 of the rms force (--noise 0.01).",
            )
        )
    scale = _scales(views)
    return [_with_stated(view, scale, noise) for view in views]


def _with_known(view: View) -> View:
    """A view without the channels of unknown noise."""
    return replace(view, force={name: x for name, x in view.force.items() if view.known(name)})


def _with_stated(view: View, scale: Mapping[str, float], noise: float) -> View:
    """A view with a stated noise where none is known."""
    given = {
        name: (noise * scale[name] * view.speed**2) ** 2 * np.eye(view.rows)
        for name in view.force
        if not view.known(name)
    }
    return replace(view, covariance={**view.covariance, **given})
