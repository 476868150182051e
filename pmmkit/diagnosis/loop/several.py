"""Several campaigns of one ship, captive and free running, as the evidence of one session."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property, partial
from pathlib import Path
from types import MappingProxyType
from typing import Any

from pmmkit.base import DataError, ModelError, TableError, Workers
from pmmkit.campaigns import Campaign
from pmmkit.conventions import Structure
from pmmkit.diagnosis.any_campaign import complete_model
from pmmkit.diagnosis.joint.captive_vote import CaptiveVote, Names, Vote, vote_of_tests
from pmmkit.diagnosis.joint.records_vote import OWN, RecordsVote
from pmmkit.diagnosis.joint.result import Together
from pmmkit.diagnosis.joint.together import answered, carried, known_from, records_among
from pmmkit.diagnosis.loop.captive import CaptiveTests, captive_tests
from pmmkit.diagnosis.loop.fall import Fall
from pmmkit.diagnosis.loop.records import FreeRecords, free_running
from pmmkit.effects import Effect
from pmmkit.identification import FreeRecord
from pmmkit.models import Model, Step, without_effect
from pmmkit.numerics import one_thread
from pmmkit.presentation import counted

Tests = Campaign | Sequence[FreeRecord]
Brought = tuple[str, Names, Names]
"""Captive tests that bring effects into the model of the records; all that they are asked for,
fitted together; those that they alone can be asked for."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SeveralCampaigns:
    """Captive tests and free-running records of one ship.

    Each campaign has noise and faults of its own. An effect is asked of all that can show it:
    captive tests and records measure it each by themselves, as the diagnosis of all of them does.
    What the captive tests know of the base is known before the records. The ship of a session is
    that of the first records; effects that captive tests alone can be asked for come to it as
    these measure them.

    Parameters
    ----------
    given_model : Model
        Complete where there are records.
    captive : mapping of str to CaptiveTests
        By the name of the campaign.
    free : mapping of str to Campaign or sequence of FreeRecord
        Free-running records, by the name of the campaign.
    order : tuple of str
        Names as they were given.
    settings : mapping of str to object
        Of the question to records, as for `diagnose_free`.
    chosen : mapping of str to Mapping of str to object
        By campaign of records which of them take part, as for `records_among`.
    own : tuple of Effect
        Effects of the user.
    tell : callable
        Is told what is being done.
    """

    given_model: Model
    captive: Mapping[str, CaptiveTests]
    free: Mapping[str, Tests]
    order: Names
    settings: Mapping[str, Any]
    chosen: Mapping[str, Mapping[str, Any]]
    own: tuple[Effect, ...] = ()
    tell: Callable[[str], None] = lambda _: None

    @property
    def title(self) -> str:
        """Of the campaigns."""
        return ", ".join(self.order)

    @property
    def base(self) -> str:
        """The base in words."""
        return self.given_model.name

    @property
    def about(self) -> str:
        """The tests in words."""
        return f"{counted(len(self.order), 'campaign')}: {self.title}"

    @property
    def floor(self) -> float:
        """What is too small to matter, over the rms force of a channel, in the first captive tests;
        in the first records where there are none."""
        return next(iter((self.captive or self.campaigns()).values())).floor

    @property
    def begun(self) -> Names:
        """Effects that the base of any campaign has from the beginning."""
        found = [name for item in self.campaigns().values() for name in item.begun]
        return tuple(dict.fromkeys(found))

    @property
    def kinds(self) -> Mapping[str, str]:
        """Who takes part in any campaign: ``physics`` or ``fault`` by name."""
        return {k: x for item in self.campaigns().values() for k, x in item.kinds.items()}

    def campaigns(self, steps: Sequence[Step] = ()) -> Mapping[str, CaptiveTests | FreeRecords]:
        """The evidence of each campaign, in the order in which they were named.

        Parameters
        ----------
        steps : sequence of Step
            What is added: effects that captive tests alone can be asked for are in the model of
            the records.
        """
        records = self._records(self._brought(steps))
        found: dict[str, CaptiveTests | FreeRecords] = {**self.captive, **records}
        return {name: found[name] for name in self.order}

    def each(
        self, steps: Sequence[Step]
    ) -> Mapping[str, tuple[CaptiveTests | FreeRecords, list[Step]]]:
        """The evidence of each campaign, and the steps that it can be asked for and has not."""
        found = self.campaigns(steps)
        return {name: (item, _asked(name, item, steps)) for name, item in found.items()}

    def named(self, effect: str, campaign: str) -> str:
        """The campaign that has a fault; empty for an effect of the ship.

        Raises
        ------
        DataError
            If there is no such campaign, or several know the fault and none is said.
        """
        known = [name for name, item in self.campaigns().items() if effect in item.kinds]
        if self.kinds[effect] != "fault":
            if campaign:
                raise DataError(f"{effect} is an effect of the ship: it is asked of all campaigns.")
            return ""
        if campaign and campaign not in known:
            raise DataError(f"{campaign!r} cannot have {effect}: these can: {', '.join(known)}.")
        if not campaign and len(known) > 1:
            raise DataError(
                f"{effect} is the fault of one campaign: say of which ({', '.join(known)})."
            )
        return campaign or known[0]

    def diagnose(self, steps: Sequence[Step], seed: int) -> Together:
        """What the campaigns say together of a base with some steps."""
        return self._answer(tuple(steps), seed)[0]

    def fall(self, steps: Sequence[Step]) -> Fall:
        """Errors of what is left out of each campaign, of the base and after each step."""
        found = {name: item.fall(asked) for name, (item, asked) in self.each(steps).items()}
        return Fall(
            added=tuple(steps),
            rows=tuple(
                replace(row, campaign=name) for name, own in found.items() for row in own.rows
            ),
            told={name: told for name, own in found.items() for told in own.told.values()},
        )

    def held_out_errors(self, steps: Sequence[Step]) -> Mapping[str, Mapping[str, float]]:
        """Errors of what is held out of each campaign, before and after; empty where nothing is."""
        return {
            f"{name}: {row}": errors
            for name, (item, asked) in self.each(steps).items()
            for row, errors in item.held_out_errors(asked).items()
        }

    def model(self, steps: Sequence[Step]) -> Model:
        """The ship of the first records, or of the first captive tests where there are none, base
        and effects fitted together, with a step per effect."""
        return self._model_of(self.ship, steps)

    @one_thread()
    def models(self, steps: Sequence[Step]) -> Mapping[str, Model]:
        """The ship as each campaign has it, base and effects fitted together."""
        return {name: self._model_of(name, steps) for name in self.order}

    @property
    def ship(self) -> str:
        """The campaign of which the ship of a session is."""
        return next(iter(self.free or self.captive))

    def _model_of(self, name: str, steps: Sequence[Step]) -> Model:
        item, asked = self.each(steps)[name]
        return item.model(asked)

    @one_thread()
    def rival(self, steps: Sequence[Step], names: Sequence[str]) -> Model:
        """The ship that a set named by `diagnose` says, with its uncertainty and without steps.

        Raises
        ------
        ModelError
            If there is no such ship.
        """
        found, votes = self._answer(tuple(steps), 0)
        entry = next((item for item in found.entries if set(item.names) == set(names)), None)
        records = [item for item in votes if isinstance(item, RecordsVote)]
        for item in (*records, *votes) if entry else ():
            ballot = entry.ballots.get(item.name) if entry else None
            made = _sailing(item, tuple(names), ballot.faults if ballot else ())
            if made is not None:
                return made
        raise ModelError(f"{' + '.join(names)} was not named.")

    def _brought(self, steps: Sequence[Step]) -> Brought | None:
        """What captive tests bring into the model of the records: effects that they alone can be
        asked for, fitted together with all else that they are asked for."""
        if not steps or not self.free:
            return None
        free = {name for item in self._records(None).values() for name in item.kinds}
        for name, item in self.captive.items():
            asked = _asked(name, item, steps)
            alone = tuple(
                x.effect
                for x in asked
                if item.kinds[x.effect] == "physics" and x.effect not in free
            )
            if alone:
                return name, tuple(x.effect for x in asked), alone
        return None

    @cached_property
    def _records(self) -> Callable[[Brought | None], Mapping[str, FreeRecords]]:
        """Records about a base to which captive tests have brought some effects, each once."""

        def made(brought: Brought | None) -> dict[str, FreeRecords]:
            based, _ = self._base(brought)
            found = {}
            for name, item in self.free.items():
                model = carried(based, name, item)[0] if isinstance(item, Campaign) else based
                used, kept = records_among(item, model, self.chosen[name])
                found[name] = free_running(
                    model,
                    used,
                    held_out=kept,
                    own=self.own,
                    progress=partial(self._of, name),
                    **self.settings,
                )
            return found

        return cache(made)

    @cached_property
    def _base(self) -> Callable[[Brought | None], tuple[Model, Names]]:
        """The model as captive tests know it, with effects that they alone can be asked for."""

        def made(brought: Brought | None) -> tuple[Model, Names]:
            if brought is not None:
                return self._ship_of(brought), ()
            tests = [
                (name, item.system, partial(_fitted, item)) for name, item in self.captive.items()
            ]
            return known_from(self.given_model, tests)

        return cache(made)

    def _ship_of(self, brought: Brought) -> Model:
        """The ship of captive tests without what the records are asked for themselves.

        It was in the fit: a base without it would have taken its place.
        """
        campaign, effects, alone = brought
        item = self.captive[campaign]
        kinds = item.kinds
        made = item.model(
            [
                Step(
                    action="fault_corrected" if kinds[name] == "fault" else "effect_added",
                    effect=name,
                )
                for name in effects
            ]
        )
        first = len(self.given_model.steps)
        kept = list(made.steps[:first])
        bare = made
        for step in reversed(made.steps[first:]):
            if step.action == "fault_corrected" or step.effect in alone:
                kept.insert(first, step)
            elif step.before is not None:
                bare = bare.restored(step.before)
            else:
                bare = without_effect(bare, step.effect)
        return bare.with_(steps=tuple(kept))

    @cached_property
    def _answer(self) -> Callable[[tuple[Step, ...], int], tuple[Together, tuple[Vote, ...]]]:
        """What is said of a base with some steps, and by whom, each base once."""
        known: dict[tuple[Any, ...], tuple[Together, tuple[Vote, ...]]] = {}

        def made(steps: tuple[Step, ...], seed: int) -> tuple[Together, tuple[Vote, ...]]:
            given = tuple((step.effect, step.campaign) for step in steps)
            if (given, seed) not in known:
                votes = self.votes(steps, seed)
                said = answered(
                    votes,
                    given=tuple(step.effect for step in steps),
                    notes=self._notes,
                    progress=self.tell,
                )
                known[given, seed] = said, votes
            return known[given, seed]

        return made

    def votes(self, steps: Sequence[Step], seed: int = 0) -> tuple[Vote, ...]:
        """The campaigns, each diagnosed alone beside a base with some steps."""
        return tuple(
            self._vote(name, item, asked, seed) for name, (item, asked) in self.each(steps).items()
        )

    @property
    def _notes(self) -> list[str]:
        """Of the bases."""
        based, notes = self._base(None)
        campaigns = [(name, x) for name, x in self.free.items() if isinstance(x, Campaign)]
        each = [carried(based, name, item)[1] for name, item in campaigns]
        return [*notes, *(text for own in each for text in own)]

    def _vote(
        self, name: str, item: CaptiveTests | FreeRecords, steps: Sequence[Step], seed: int
    ) -> CaptiveVote | RecordsVote:
        if isinstance(item, FreeRecords):
            given = item.sets(steps)[-1]
            return RecordsVote(
                name=name,
                system=item.system,
                diagnosis=item.diagnose(steps, seed),
                contest=item.contest(given),
                given=given,
                held_out=item.held_out,
                held_out_window=item.held_out_window,
            )
        self._of(name, "captive tests")
        tests = item.standing(steps)
        return vote_of_tests(
            name,
            self.given_model,
            item.campaign,
            tests.system,
            tests.begun,
            own=self.own,
            unseen=item.unseen,
            seed=seed,
        )

    def _of(self, name: str, word: str) -> None:
        self.tell(f"{name}: {word}")


def several_campaigns(
    model: Model | str | Path | Sequence[str] | Structure,
    campaigns: Mapping[str, Tests],
    *,
    floor: float | None,
    noise: float | None,
    own: Sequence[Effect],
    executor: Workers = None,
    progress: Callable[[str], None] | None = None,
    **settings: Any,
) -> SeveralCampaigns:
    """The evidence of several campaigns; arguments as for `begin`."""
    if not campaigns:
        raise DataError("There is no campaign: give captive tests or free-running records.")
    complete = complete_model(model)
    free = {
        name: item
        for name, item in campaigns.items()
        if not isinstance(item, Campaign) or item.kind == "free-running"
    }
    tests = {
        name: item
        for name, item in campaigns.items()
        if isinstance(item, Campaign) and name not in free
    }
    opened = {name: item for name, item in campaigns.items() if isinstance(item, Campaign)}
    kept = Campaign.fitting(opened, settings.pop("test_runs", None) or ())
    if settings and not free:
        raise DataError(f"Of no use for captive tests: {', '.join(settings)}.")
    sailed = {name: item for name, item in opened.items() if name in free}
    runs = Campaign.fitting(sailed, settings.pop("runs", None) or ())
    among = {name: settings.pop(name, None) for name in ("channels", "shortest")}
    captive = {}
    for name, item in tests.items():
        held = item.matching(kept[name]) if name in kept else []
        captive[name] = captive_tests(
            complete,
            item.with_(runs=tuple(run for run in item.runs if run not in held)) if held else item,
            floor=floor,
            candidates=None,
            noise=noise,
            own=own,
            executor=executor,
            held_out=held,
        )
    return SeveralCampaigns(
        given_model=complete,
        captive=MappingProxyType(captive),
        free=MappingProxyType(free),
        order=tuple(campaigns),
        settings=MappingProxyType(
            {
                "floor": None if tests else floor,
                "candidates": None,
                "most": OWN,
                "executor": executor,
                **settings,
            }
        ),
        chosen=MappingProxyType(
            {x: {**among, "runs": runs.get(x), "test_runs": kept.get(x)} for x in free}
        ),
        own=tuple(own),
        tell=progress or (lambda _: None),
    )


def _asked(name: str, item: CaptiveTests | FreeRecords, steps: Sequence[Step]) -> list[Step]:
    """The steps that a campaign can be asked for, and does not have."""
    mine = [x for x in steps if x.campaign in ("", name)]
    return [x for x in mine if x.effect in item.kinds and x.effect not in item.begun]


def _fitted(item: CaptiveTests) -> Model | None:
    """The model with its derivatives fitted to captive tests; None if they excite too little."""
    try:
        return item.rival((), ())
    except (ModelError, TableError):
        return None


def _sailing(vote: Vote, names: Names, faults: Names) -> Model | None:
    """The ship of a campaign with a set of effects, with its uncertainty."""
    if not isinstance(vote, RecordsVote):
        return vote.model_with(names, faults)
    fit = vote.steady(frozenset((*(x for x in names if x in vote.asked), *faults)))
    return None if fit is None else vote.model_of(fit)
