"""Captive tests as the evidence of a session."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from itertools import pairwise
from pathlib import Path
from typing import Final, Protocol, TypeVar

import numpy as np

from pmmkit.base import DataError, ModelError, Progress, Workers
from pmmkit.campaigns import Campaign, Run
from pmmkit.conventions import CHANNEL_UNITS, Structure
from pmmkit.diagnosis.captive.adequacy import blocks_of
from pmmkit.diagnosis.captive.candidate import Candidate
from pmmkit.diagnosis.captive.diagnose import captive_system, derivatives_of, standing
from pmmkit.diagnosis.captive.formula import answer_with_formula
from pmmkit.diagnosis.captive.held_out import FORCE, HeldOut, held_out, missed
from pmmkit.diagnosis.captive.hidden_entries import OutsideCheck
from pmmkit.diagnosis.captive.least_squares import (
    JointFit,
    Stack,
    joint_fit,
    sizes_of,
    solved,
    stacked,
)
from pmmkit.diagnosis.captive.refit import froude_numbers, places_of, refitted, written_in
from pmmkit.diagnosis.captive.system import CandidateColumns, System
from pmmkit.diagnosis.captive.verdict import about, coefficients_of, taken_as_given
from pmmkit.diagnosis.evidence import RankedSet, Visible
from pmmkit.diagnosis.findings import Diagnosis
from pmmkit.diagnosis.joint.result import Together
from pmmkit.diagnosis.loop.fall import ALL, BASE, ErrorWords, Fall, FallRow
from pmmkit.diagnosis.refit import stepped
from pmmkit.effects import CATALOGUE, Effect
from pmmkit.intake import Untold
from pmmkit.models import Model, Step
from pmmkit.numerics import Array, one_thread
from pmmkit.presentation import counted
from pmmkit.reduction import View

# What each candidate alone would do to captive tests, before anything is added.


Changes = dict[str, dict[str, Array]]
"""Change of the model by run and channel, harmonic by harmonic [N, N m]."""


def alone_in_tests(
    system: System,
    given: Sequence[str],
    chosen: Sequence[RankedSet],
    heard: Callable[[int, str], None],
    *,
    changes: bool = True,
) -> tuple[dict[str, dict[str, float]], dict[str, Changes]]:
    """Shares of the error that candidates take away, and what they change, each beside the base;
    `noise`: the share that goes where noise alone is left."""
    beside, _, known = taken_as_given(system, given)
    base = held_out(system, known, with_spread=False)
    before, noise = base.of_channel(), 1.0 - (base.share(kind="level") / base.share()) ** 2
    each = [tuple(blocks_of(beside, entry)) for entry in chosen]
    shares = {}
    for number, (entry, own) in enumerate(zip(chosen, each, strict=True)):
        heard(number, entry.names[0])
        errors = held_out(system, (*known, *own), with_level=False)
        shares[entry.names[0]] = {
            "all": 1.0 - (errors.share() / base.share()) ** 2,
            "noise": noise,
        } | {name: 1.0 - (after / before[name]) ** 2 for name, after in errors.of_channel().items()}
    if not changes:
        return shares, {}
    # One stack for all: the features of the smooth floor cost most, and are the same for each.
    stack = stacked(system, [*known, *(block for own in each for block in own)], floor=system.floor)
    first = stack.begin + _width(known)
    edges = np.cumsum([first, *map(_width, each)]).tolist()
    without = _forces(stack, first, range(0))
    return shares, {
        entry.names[0]: _change(system, without, _forces(stack, first, range(begin, end)))
        for entry, (begin, end) in zip(chosen, pairwise(edges), strict=True)
    }


def _width(blocks: Sequence[CandidateColumns]) -> int:
    """Number of columns of some effects."""
    return sum(len(sizes_of(block)) for block in blocks)


def _forces(stack: Stack, known: int, more: range) -> dict[str, Array]:
    """Forces of all rows by channel [N, N m] with the base, its effects and the columns of one
    candidate fitted."""
    floor = range(len(stack.names), stack.white.shape[1])
    kept = np.array([*range(known), *more, *floor])
    effects = kept[stack.begin : -1] - stack.begin
    one = replace(stack, white=stack.white[:, kept], centre=stack.centre[effects])
    count = known + len(more)
    fitted = stack.plain[:, kept[:count]] @ solved(one).solution[:count]
    return {name: fitted[rows] for name, rows in stack.places.items()}


def _change(system: System, before: Mapping[str, Array], after: Mapping[str, Array]) -> Changes:
    """Differences of forces by run and channel; the second cycle by itself is left out."""
    changes: Changes = {}
    for channel in system.channels:
        moved = after[channel.name] - before[channel.name]
        for i, rows in zip(channel.views, channel.rows, strict=True):
            view = system.views[i]
            if not view.early:
                changes.setdefault(view.run.id, {})[channel.name] = moved[rows]
    return changes


# What a session is about: tests and a base, and what is asked of them.


Said_co = TypeVar("Said_co", bound=Diagnosis | Together, covariant=True)
"""What a diagnosis is, of one campaign or of several."""


class SessionEvidence(Protocol[Said_co]):
    """Tests, a base, and all that may be missing of it.

    What takes long is worked out once, when it is first needed.
    """

    @property
    def title(self) -> str:
        """Of the tests."""

    @property
    def base(self) -> str:
        """The base in words."""

    @property
    def about(self) -> str:
        """The tests in words."""

    @property
    def floor(self) -> float:
        """What is too small to matter, over the rms force of a channel."""

    @property
    def begun(self) -> tuple[str, ...]:
        """Effects that the base has from the beginning."""

    @property
    def kinds(self) -> Mapping[str, str]:
        """Who takes part: ``physics`` or ``fault`` by name."""

    @property
    def own(self) -> tuple[Effect, ...]:
        """Effects of the user."""

    def named(self, effect: str, campaign: str) -> str:
        """The campaign that a step is about: empty where it is about all there are."""

    def diagnose(self, steps: Sequence[Step], seed: int) -> Said_co:
        """What the base still lacks with some steps."""

    def fall(self, steps: Sequence[Step]) -> Fall:
        """Errors of what is left out, of the base and after each step."""

    def held_out_errors(self, steps: Sequence[Step]) -> Mapping[str, Mapping[str, float]]:
        """Errors of records that are held out, before and after; empty where there are none."""

    def model(self, steps: Sequence[Step]) -> Model:
        """Base and effects fitted together, with a step per effect."""

    def rival(self, steps: Sequence[Step], names: Sequence[str]) -> Model:
        """The ship that a set named by `diagnose` says, with its uncertainty and without steps."""


def only_campaign(title: str, effect: str, campaign: str) -> str:
    """`Evidence.named` where there is one campaign alone: nothing has to be said."""
    if campaign not in ("", title):
        raise DataError(f"{effect}: there is no campaign {campaign!r}, but {title!r}.")
    return ""


Names = tuple[str, ...]
TOLD: Final = ErrorWords(
    of=FORCE,
    judged=(FORCE,),
    left_out="conditions",
    total="{} of the rms force",
    how="Each condition was left out of the fit in turn, with its repeats, and predicted from all "
    "others: root mean square of the error in newtons and in per cent of the channel's rms force, "
    "beside what noise alone gives.",
)


@dataclass(frozen=True, kw_only=True, eq=False)
class CaptiveTests:
    """Captive tests, a base, and what may be missing of it.

    `source`: the base: a model, the name of a structure, or derivatives. `system`: runs, base
    and candidates. `floor`: what is too small to matter, over the rms force of a channel.
    `begun`: effects that the base has from the beginning. `own`: effects of the user. `outside`:
    what is asked of names. `unseen`: runs that are held out.
    """

    source: Model | str | tuple[str, ...] | Structure
    campaign: Campaign
    system: System
    floor: float
    outside: OutsideCheck
    begun: tuple[str, ...] = ()
    own: tuple[Effect, ...] = ()
    unseen: tuple[View, ...] = ()

    @property
    def title(self) -> str:
        """Of the tests."""
        return self.campaign.title

    @property
    def base(self) -> str:
        """The base in words."""
        if isinstance(self.source, tuple):
            return counted(len(self.source), "derivative")
        return str(getattr(self.source, "name", self.source))

    @property
    def about(self) -> str:
        """The tests in words."""
        return f"{counted(len(self.campaign), 'run')} of {self.campaign.title}"

    @property
    def kinds(self) -> Mapping[str, str]:
        """Who takes part: ``physics`` or ``fault`` by name."""
        return {block.candidate.name: block.candidate.kind for block in self.system.blocks}

    @cached_property
    def _about(self) -> Callable[[tuple[str, ...]], tuple[System, tuple[CandidateColumns, ...]]]:
        """The system about its base with some effects, and these, each set of names once."""
        return cache(lambda names: about(self.system, names))

    @cached_property
    def _left_out(self) -> Callable[[tuple[str, ...]], HeldOut]:
        """Errors of what is left out with some effects, each set of them once."""
        return cache(lambda names: held_out(*self._about(names)))

    def named(self, effect: str, campaign: str) -> str:
        """Nothing: there is one campaign alone."""
        return only_campaign(self.title, effect, campaign)

    def diagnose(self, steps: Sequence[Step], seed: int) -> Diagnosis:
        """What the base still lacks with some steps."""
        own = self.standing(steps)
        found = answer_with_formula(
            own.system, own.begun, floor=own.floor, seed=seed, source=self.source
        )
        found = self.outside.judged(found, own.system, own.begun, self.source)
        untold = Untold.of(self.campaign.within_reach(), values=found.base, recorded=True)
        return replace(found, given=self._names(steps), untold=untold)

    def standing(self, steps: Sequence[Step]) -> CaptiveTests:
        """The tests about the base with some steps, as the model stands that is written with them:
        derivatives that a step brought are the base's own."""
        return self._standing(tuple(step.effect for step in steps))

    @cached_property
    def _standing(self) -> Callable[[tuple[str, ...]], CaptiveTests]:
        """The tests about a base with some effects, each set of them once."""

        def made(names: tuple[str, ...]) -> CaptiveTests:
            system, rest = standing(self.system, names, self.own)
            begun = tuple(dict.fromkeys((*self.begun, *rest)))
            return replace(self, system=system.whole(begun), begun=begun)

        return cache(made)

    def fall(self, steps: Sequence[Step]) -> Fall:
        """Held-out errors of the base and after each step."""
        named = self._names(steps)
        first = len(self.begun)
        names = (BASE, *(step.effect for step in steps))
        found = [self._left_out(named[: first + number]) for number in range(len(names))]
        rows = [
            row
            for name, before, after in zip(names, [None, *found], found, strict=False)
            for row in _fall_rows(name, self.title, after, before)
        ]
        mine = tuple(replace(step, campaign="") for step in steps)
        return Fall(added=mine, rows=tuple(rows), told={self.title: TOLD})

    def held_out_errors(self, steps: Sequence[Step]) -> dict[str, dict[str, float]]:
        """Errors of runs that are held out, the base fitted to the others, without and with the
        effects; without such runs none: conditions are left out in turn instead."""
        if not self.unseen:
            return {}
        rows = {"held out, base refitted": self.begun}
        if steps:
            rows["held out, with the effects"] = self._names(steps)
        found = {}
        for row, names in rows.items():
            system, blocks = self._about(names)
            fit = joint_fit(system, blocks, floor=self.floor)
            found[row] = missed(self.unseen, system.base, blocks, fit)
        return found

    @one_thread()
    def alone(
        self,
        steps: Sequence[Step],
        chosen: Sequence[RankedSet],
        heard: Callable[[int, str], None],
        *,
        numbers: int,
    ) -> tuple[dict[str, dict[str, float]], dict[str, Changes], dict[str, Changes]]:
        """What each candidate would do, alone beside the base with some steps: the share of the
        error that it takes away, what it changes; nothing of the base alone."""
        tests = self.standing(steps)
        shares, changes = alone_in_tests(
            tests.system, tests.begun, chosen, heard, changes=numbers > 0
        )
        return shares, changes, {}

    def why_not_asked(self, effect: Effect, covered: Sequence[Visible]) -> str:
        """Why an effect takes no part, in words, as the coverage of a diagnosis has it."""
        return next(item.why for item in covered if item.name == effect.name)

    def fitted(self, _steps: Sequence[Step]) -> frozenset[str]:
        """Effects that were fitted by other than one linear problem for all: none."""
        return frozenset()

    def model(self, steps: Sequence[Step]) -> Model:
        """The model with base and effects fitted together, and with a step per effect."""
        source, fit, ship, notes = self._sailing(self._names(steps))
        made = ship.with_(notes=tuple(dict.fromkeys((*ship.notes, *notes))))
        _, blocks = self._about(self._names(steps))
        plain = Step(
            action="fitted",
            campaign=self.campaign.title or self.campaign.ship.name,
            count=fit.std.size,
            Fn=froude_numbers(self.campaign),
            faults=tuple(x.candidate.name for x in blocks if x.candidate.kind == "fault"),
        )
        errors = [x / 100.0 for x in self.fall(steps).totals] if steps else []
        added = list(zip(steps, blocks[len(self.begun) :], strict=True))
        return stepped(
            source,
            made,
            plain,
            [_at_its_parameter(step, block) for step, block in added],
            [
                (
                    _coefficients(block, fit),
                    places_of(block, made, self.own) if block.candidate.kind == "physics" else (),
                )
                for _, block in added
            ],
            errors,
        )

    @one_thread()
    def rival(self, steps: Sequence[Step], names: Sequence[str]) -> Model:
        """The ship that a set named by `diagnose` says, with its uncertainty and without steps."""
        return self._sailing((*self._names(steps), *names))[2]

    def _sailing(self, effects: Names) -> tuple[Model, JointFit, Model, Names]:
        """The ship of the base, what is fitted together with some effects, the ship of that, and
        what could not be taken over."""
        if not isinstance(self.source, Model):
            raise ModelError(
                f"The base {self.source!r} is a list of derivatives. Begin with a model: reduce "
                f"the campaign first, then take its model.toml."
            )
        system, blocks = self._about(effects)
        fit = joint_fit(system, blocks, floor=self.floor)
        ship, notes = refitted(self.source, fit, blocks, system.base, self.campaign, self.own)
        return self.source, fit, ship, notes

    def _names(self, steps: Sequence[Step]) -> tuple[str, ...]:
        return (*self.begun, *(step.effect for step in steps))


def _at_its_parameter(step: Step, block: CandidateColumns) -> Step:
    """A step with the nonlinear parameter of its effect."""
    name = block.candidate.parameter
    return replace(step, parameter=name, value=block.value if name else None)


def _coefficients(block: CandidateColumns, fit: JointFit) -> dict[str, float]:
    """Coefficients of an effect by a fit, those of a fault as the catalogue names them."""
    c = block.candidate
    known = CATALOGUE.get(c.name)
    names = list(known.typical) if c.kind == "fault" and known else c.coefficients
    return dict(zip(names, coefficients_of(block, fit)[0], strict=True))


def captive_tests(
    model: Model | str | Path | Sequence[str] | Structure,
    campaign: Campaign,
    *,
    floor: float | None,
    candidates: Sequence[Candidate] | None,
    noise: float | None,
    own: Sequence[Effect],
    executor: Workers = None,
    outside: bool = False,
    progress: Progress | None = None,
    held_out: Sequence[Run] = (),
) -> CaptiveTests:
    """The evidence of captive tests; arguments as for `begin`."""
    source, structure, effects = derivatives_of(model)
    own = written_in(source if isinstance(source, Model) else None, own)
    system = captive_system(
        campaign,
        structure,
        floor=floor,
        candidates=candidates,
        noise=noise,
        own=own,
        executor=executor,
    )
    begun = system.taking_part(effects)
    return CaptiveTests(
        source=source,
        campaign=campaign,
        system=system.whole(begun),
        floor=system.floor,
        outside=OutsideCheck.beside(
            campaign.folder, made=outside, executor=executor, progress=progress
        ),
        begun=begun,
        own=own,
        unseen=tuple(
            View.of(
                campaign.with_(runs=tuple(held_out)).within_reach(),
                unknown_noise=True,
                executor=executor,
            )
            if held_out
            else ()
        ),
    )


def _fall_rows(
    step: str, campaign: str, after: HeldOut, before: HeldOut | None
) -> Iterator[FallRow]:
    """Errors after a step: of all channels together and of each, of all kinds of test and of each.

    The channels are judged together, on the scale of their forces; free-running records have no
    such scale.
    """
    better = math.nan if before is None else after.better_than(before)
    force = after.of_channel(kind="force")
    for test in (None, *dict.fromkeys(after.tests)):
        group, share = test or ALL, better if test is None else math.nan
        yield FallRow(
            step=step,
            campaign=campaign,
            group=group,
            quantity=FORCE,
            error=100.0 * after.share(test),
            level=100.0 * after.share(test, kind="level"),
            unit="%",
            better=share,
        )
        levels = after.of_channel(test, kind="level")
        for channel, error in after.of_channel(test).items():
            yield FallRow(
                step=step,
                campaign=campaign,
                group=group,
                quantity=channel,
                error=error,
                level=levels[channel],
                unit=CHANNEL_UNITS[channel],
                force=force[channel],
                better=share,
            )
