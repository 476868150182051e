"""The loop without a screen: diagnose, add, watch the error fall, undo, replay."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Generic, TypeGuard, TypeVar, overload

from pmmkit.base import DataError, ModelError, Workers
from pmmkit.campaigns import Campaign
from pmmkit.conventions import Structure
from pmmkit.diagnosis.captive.candidate import Candidate, no_such_effect
from pmmkit.diagnosis.empirical import noted
from pmmkit.diagnosis.findings import Diagnosis, Finding
from pmmkit.diagnosis.free_running.hypotheses import FreeCandidate
from pmmkit.diagnosis.joint.result import Together
from pmmkit.diagnosis.loop.captive import SessionEvidence, captive_tests
from pmmkit.diagnosis.loop.fall import Fall
from pmmkit.diagnosis.loop.records import free_running
from pmmkit.diagnosis.loop.several import Tests, several_campaigns
from pmmkit.effects import Effect, is_fault
from pmmkit.files import read_toml, toml_text, write_text
from pmmkit.identification import FreeRecord
from pmmkit.models import FileReader, Model, Step, load_model, odds, without_effect
from pmmkit.numerics import one_thread
from pmmkit.presentation import Described, Section, counted

# Files of steps, as `Session.save` writes them.


@dataclass(frozen=True, kw_only=True)
class SavedSession:
    """What a file of steps holds.

    `floor`: what is too small to matter, over the rms force of a channel. `steps`: effects and
    faults in the order in which they were added. `campaign`: title of the tests.
    """

    floor: float
    steps: tuple[Step, ...]
    campaign: str = ""

    def save(self, path: str | Path) -> None:
        """Write it as TOML, all or nothing."""
        data: dict[str, Any] = {
            "session": {"campaign": self.campaign, "floor": self.floor},
            "steps": [step.entries for step in self.steps],
        }
        write_text(Path(path), toml_text(data))


def read_session(path: str | Path) -> SavedSession:
    """The steps of a file, checked.

    Parameters
    ----------
    path : str or path
        Of this release or of the first, whose ``[session]`` has the lists ``effects`` and ``why``.

    Raises
    ------
    ModelError
        If the file is damaged or of another kind.
    """
    data = read_toml(Path(path))
    head = data.get("session")
    floor = head.get("floor") if isinstance(head, dict) else None
    if not isinstance(head, dict) or not isinstance(floor, float):
        raise ModelError(f"{path} is no session: [session] needs the number floor.")
    reader = FileReader(str(path))
    steps = _first_release(head, str(path)) if "effects" in head else reader.steps(data)
    for number, step in enumerate(steps, start=1):
        if step.action not in ("effect_added", "fault_corrected") or not step.effect:
            reader.fault(f"steps.{number} adds no effect: a session has no other steps.")
    if reader.problems:
        raise ModelError(reader.problems, title="This is no session")
    title = head.get("campaign")
    return SavedSession(floor=floor, steps=steps, campaign=title if isinstance(title, str) else "")


def _first_release(head: dict[str, Any], path: str) -> tuple[Step, ...]:
    """Steps from a list of effects and one of remarks."""
    lists = [head.get(name) for name in ("effects", "why")]
    texts = [x for x in lists if isinstance(x, list) and all(isinstance(t, str) for t in x)]
    if len(texts) != 2 or len(texts[0]) != len(texts[1]):
        raise ModelError(
            f"{path} is no session: its lists effects and why must be texts of equal number."
        )
    return tuple(
        Step(
            action="fault_corrected" if is_fault(effect) else "effect_added",
            effect=effect,
            note=why,
        )
        for effect, why in zip(*texts, strict=True)
    )


Said = TypeVar("Said", bound=Diagnosis | Together)
"""What a diagnosis is, of one campaign or of several."""
Base = Model | str | Path | Sequence[str] | Structure
"""What a session begins with."""


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Session(Described, Generic[Said]):
    """A base model, the tests, and the effects that were added one after another.

    Each action gives a new session; the old one stays as it is. All of them share what was worked
    out of the tests.

    Parameters
    ----------
    evidence : SessionEvidence
        The tests, captive or free-running, of one campaign or of several, and the base.
    steps : tuple of Step
        What was added.
    """

    evidence: SessionEvidence[Said]
    steps: tuple[Step, ...] = ()

    @property
    def given(self) -> tuple[str, ...]:
        """Effects that the base has now."""
        return (*self.evidence.begun, *(step.effect for step in self.steps))

    @one_thread()
    def diagnose(self, seed: int = 0) -> Said:
        """What the base, with the effects added so far, still lacks; of several campaigns what
        they say together."""
        return self.evidence.diagnose(self.steps, seed)

    def add(
        self,
        effect: str | Finding | Step,
        why: str = "",
        *,
        campaign: str = "",
        log_odds: float | None = None,
    ) -> Session[Said]:
        """A session with one effect more.

        Parameters
        ----------
        effect : str, Finding or Step
            Its name, or a finding of `diagnose` or a step of another session, whose odds are kept.
        why : str
            A remark.
        campaign : str
            Of several, the one that has the fault; an effect of the ship is asked of all.
        log_odds : float, optional
            ln of the odds for an effect that is given by its name.

        Raises
        ------
        UnknownNameError
            If no such effect takes part.
        DataError
            If it is not said which of several campaigns has a fault, or there is no such one.
        ModelError
            If the base has it already.
        """
        name = effect if isinstance(effect, str) else effect.effect
        kinds = self.evidence.kinds
        if name not in kinds:
            raise no_such_effect(name, list(kinds))
        of = campaign or (effect.campaign if isinstance(effect, Step) else "")
        of = self.evidence.named(name, of)
        if name in self.evidence.begun or (name, of) in [
            (x.effect, x.campaign) for x in self.steps
        ]:
            raise ModelError(f"The model has {name} already.")
        step = Step(
            action="fault_corrected" if kinds[name] == "fault" else "effect_added",
            effect=name,
            campaign=of,
            log_odds=log_odds if isinstance(effect, str) else effect.log_odds,
            note=noted(name, why),
        )
        return replace(self, steps=(*self.steps, step))

    def undo(self) -> Session[Said]:
        """The session before the last step.

        Raises
        ------
        ModelError
            If there is no step.
        """
        if not self.steps:
            raise ModelError("There is no step to undo.")
        return replace(self, steps=self.steps[:-1])

    @one_thread()
    def fall(self) -> Fall:
        """Errors of what is left out, of the base and after each step."""
        return self.evidence.fall(self.steps)

    @one_thread()
    def held_out_errors(self) -> Mapping[str, Mapping[str, float]]:
        """Errors of what is held out, before and after; empty where nothing is."""
        return self.evidence.held_out_errors(self.steps)

    @one_thread()
    def model(self) -> Model:
        """The model with base and effects fitted together, and with a step per effect.

        Raises
        ------
        ModelError
            If the base is a structure: it has no ship to sail with.
        """
        return self.evidence.model(self.steps)

    def _headline(self) -> str:
        steps = f" + {' + '.join(self.given)}" if self.given else ""
        return f"{self.evidence.base}{steps} on {self.evidence.about}"

    def _sections(self) -> Sequence[Section]:
        steps = [_told(step) for step in self.steps] or ["none yet: diagnose, then add"]
        begun = self.evidence.begun
        asked = counted(len(self.evidence.kinds) - len(self.given), "candidate")
        return [
            Section(
                paragraphs=[
                    f"What is smooth and below {100 * self.evidence.floor:g} % of a channel's rms "
                    f"force is left alone; {asked} are asked.",
                    *([f"The base began with: {', '.join(begun)}."] if begun else []),
                ]
            ),
            Section(title="Steps", points=steps),
        ]

    def save(self, path: str | Path) -> None:
        """Write the steps as TOML, all or nothing; `replay` carries them out again."""
        SavedSession(
            campaign=self.evidence.title, floor=self.evidence.floor, steps=self.steps
        ).save(path)


def _told(step: Step) -> str:
    """An effect that was added, and why."""
    evidence = "" if step.log_odds is None else f"evidence {odds(step.log_odds)}"
    why = "; ".join(text for text in (evidence, step.note) if text)
    return f"{step.effect}: {why}" if why else step.effect


@overload
def begin(
    model: Base,
    campaign: Campaign | Sequence[FreeRecord],
    *,
    floor: float | None = None,
    candidates: Sequence[Candidate | FreeCandidate | Effect | str] | None = None,
    noise: float | None = None,
    own: Sequence[Effect] = (),
    executor: Workers = None,
    **settings: Any,
) -> Session[Diagnosis]: ...


@overload
def begin(
    model: Base,
    campaign: Sequence[Campaign] | Mapping[str, Tests],
    *,
    floor: float | None = None,
    candidates: Sequence[FreeCandidate | Effect | str] | None = None,
    noise: float | None = None,
    own: Sequence[Effect] = (),
    executor: Workers = None,
    **settings: Any,
) -> Session[Together]: ...


def begin(
    model: Base,
    campaign: Campaign | Sequence[FreeRecord] | Sequence[Campaign] | Mapping[str, Tests],
    *,
    floor: float | None = None,
    candidates: Sequence[Candidate | FreeCandidate | Effect | str] | None = None,
    noise: float | None = None,
    own: Sequence[Effect] = (),
    executor: Workers = None,
    **settings: Any,
) -> Session[Diagnosis] | Session[Together]:
    """A session about a model and its tests.

    Parameters
    ----------
    model : Model, str, path, sequence of str or Structure
        As for `diagnose`: free-running records, and several campaigns, need a complete model.
    campaign : Campaign or sequence of FreeRecord, sequence of Campaign, or mapping of str to these
        Captive tests with histories, or free-running records; or several campaigns of one ship,
        by name if a mapping, as for `together`.
    floor, candidates, noise, own, executor
        As for `diagnose_captive`, or for `diagnose_free`, which tells the noise from the records.
        Of several campaigns ``noise``, and ``floor`` where there are any, are those of captive
        tests, ``candidates`` are those of records.
    **settings
        Of captive tests ``outside`` and ``progress``, as for `diagnose_captive`. Of free-running
        records as for `diagnose_free`; of several campaigns also ``runs``, ``channels`` and
        ``shortest``, as for `Chosen.of`, and ``test_runs``: patterns of runs that are held out, of
        captive tests too.

    Returns
    -------
    Session
        Of several campaigns `Session.diagnose` gives what they say together.

    Raises
    ------
    DataError
        If captive tests hold no run with a known noise, records are too few, or an argument is of
        no use for such tests.
    """
    if not _is_one(campaign):
        more = settings if candidates is None else settings | {"candidates": candidates}
        several = several_campaigns(
            model, _by_name(campaign), floor=floor, noise=noise, own=own, executor=executor, **more
        )
        return Session(evidence=several)
    if not isinstance(campaign, Campaign) or campaign.kind == "free-running":
        if noise is not None:
            raise DataError(
                "noise belongs to captive tests. Free-running records tell theirs, or state it "
                "by channel as sensors."
            )
        records = free_running(
            model,
            campaign,
            floor=floor,
            candidates=candidates,
            own=own,
            executor=executor,
            **settings,
        )
        return Session(evidence=records)
    outside = bool(settings.pop("outside", False))
    progress = settings.pop("progress", None)
    if settings:
        raise DataError(f"Of no use for captive tests: {', '.join(settings)}.")
    asked: list[Candidate] | None = None if candidates is None else []
    for item in candidates or ():
        if not isinstance(item, Candidate):
            raise DataError(f"{item} is no candidate of captive tests: give a Candidate.")
        if asked is not None:
            asked.append(item)
    tests = captive_tests(
        model,
        campaign,
        floor=floor,
        candidates=asked,
        noise=noise,
        own=own,
        executor=executor,
        outside=outside,
        progress=progress,
    )
    return Session(evidence=tests)


def _is_one(
    campaign: Campaign | Sequence[FreeRecord] | Sequence[Campaign] | Mapping[str, Tests],
) -> TypeGuard[Campaign | Sequence[FreeRecord]]:
    """Whether it is one campaign, or its records."""
    if isinstance(campaign, Campaign):
        return True
    return not isinstance(campaign, Mapping) and not any(isinstance(x, Campaign) for x in campaign)


def _by_name(campaigns: Iterable[Any] | Mapping[str, Tests]) -> Mapping[str, Tests]:
    """Several campaigns, by their titles where they have no other names."""
    if isinstance(campaigns, Mapping):
        return campaigns
    every = list(campaigns)
    found = [item for item in every if isinstance(item, Campaign)]
    if len(found) < len(every):
        raise DataError("Records beside campaigns need a name: give a mapping of names to both.")
    return Campaign.by_title(found)


@overload
def replay(
    path: str | Path, model: Base, campaign: Campaign | Sequence[FreeRecord], **settings: Any
) -> Session[Diagnosis]: ...


@overload
def replay(
    path: str | Path,
    model: Base,
    campaign: Sequence[Campaign] | Mapping[str, Tests],
    **settings: Any,
) -> Session[Together]: ...


def replay(
    path: str | Path,
    model: Base,
    campaign: Campaign | Sequence[FreeRecord] | Sequence[Campaign] | Mapping[str, Tests],
    **settings: Any,
) -> Session[Diagnosis] | Session[Together]:
    """The steps of a file carried out again on a model and its tests.

    Parameters
    ----------
    path : str or path
        Written by `Session.save`. Nothing in it is executed.
    model, campaign, **settings
        As for `begin`; the floor is that of the file.

    Raises
    ------
    ModelError
        If the file is damaged or of another kind.
    """
    saved = read_session(path)
    session: Session[Any] = begin(model, campaign, **settings | {"floor": saved.floor})
    for step in saved.steps:
        session = session.add(step, step.note)
    return session


def fit(
    model: Model | str | Path,
    campaign: Campaign,
    *,
    floor: float | None = None,
    noise: float | None = None,
) -> Model:
    """A model with its derivatives and effects fitted together to captive tests.

    Parameters
    ----------
    model : Model, str or path
        Says what is fitted: its derivatives of hull and added mass, and those of its effects that
        have usual sizes. Propeller, rudder and inertia stay as they are.
    campaign : Campaign
        Captive tests with histories, or free-running records.
    floor : float, optional
        As for `diagnose_captive`, where it widens the uncertainty, or for `diagnose_free`.
    noise : float, optional
        As for `diagnose_captive`.

    Returns
    -------
    Model
        With a step more, and of captive tests with covariance.

    Raises
    ------
    DataError
        If the campaign holds no run with a known noise, or no record.
    """
    loaded = model if isinstance(model, Model) else load_model(model)
    if campaign.kind == "free-running":
        return begin(loaded, campaign, floor=floor, noise=noise, candidates=()).model()
    return begin(loaded, campaign, floor=floor, noise=noise).model()


def undone(model: Model, own: Sequence[Effect] = ()) -> tuple[Model, str]:
    """A model without the effect that was added last, and its name; its values are to be refitted.

    Parameters
    ----------
    model : Model
        With a step that added an effect, or corrected a fault.
    own : sequence of Effect
        Effects of the user.

    Returns
    -------
    (Model, str)
        What the effect brought is taken out, and what it changed is as it was before. Where the
        step does not tell (files of the first release), all derivatives of the effect are taken
        out, as `without_effect` does.

    Raises
    ------
    ModelError
        If its steps know of no effect that was added.
    """
    there = model.added
    if not there:
        raise ModelError(f"The history of {model.name} knows of no effect that was added.")
    last = there[-1]
    step = model.steps[last]
    if step.action == "fault_corrected":
        bare = model
    elif step.before is None:
        bare = without_effect(
            model, next((item for item in own if item.name == step.effect), step.effect)
        )
    else:
        bare = model.restored(step.before)
    left = (*model.steps[:last], *model.steps[last + 1 :])
    return bare.with_(steps=()).stepped(*left), step.effect
