"""The loop without a screen: diagnose, add, watch the error fall, undo, replay."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Final

from pmmkit.campaigns.run import Campaign
from pmmkit.diagnosis.captive.candidate import Candidate, no_such_effect
from pmmkit.diagnosis.captive.diagnose import captive_system, derivatives_of
from pmmkit.diagnosis.captive.held_out import held_out
from pmmkit.diagnosis.captive.joint_fit import JointFit, joint_fit, refined
from pmmkit.diagnosis.captive.refit import froude_numbers, places_of, refitted
from pmmkit.diagnosis.captive.system import Block, System
from pmmkit.diagnosis.captive.verdict import answer, coefficients_of, taken_as_given
from pmmkit.diagnosis.findings import Diagnosis, Finding
from pmmkit.diagnosis.free_running.refit import fit_to_records
from pmmkit.diagnosis.free_running.unknown import FLOOR as FREE_FLOOR
from pmmkit.effects.effect import Effect
from pmmkit.errors import ModelError
from pmmkit.files import write_text
from pmmkit.loop.error_fall import ErrorFall
from pmmkit.loop.saved import read_session
from pmmkit.models import Model, load_model
from pmmkit.models.changes import before_of, restored
from pmmkit.models.edit import without_effect
from pmmkit.models.records import entries
from pmmkit.models.step import Step, last_added, odds
from pmmkit.presentation import Described, Section, counted
from pmmkit.structures import Structure
from pmmkit.toml_files import toml_text

BASE: Final = "base"
"""First line of an error fall: the model before any step."""


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Session(Described):
    """A base model, the tests, and the effects that were added one after another.

    Each action gives a new session; the old one stays as it is.

    Parameters
    ----------
    source : Model, str or sequence of str
        The base: a model, the name of a structure, or derivatives.
    campaign : Campaign
        Captive tests.
    system : System
        Runs, base and candidates.
    floor : float
        What is too small to matter, over the rms force of a channel.
    begun : tuple of str
        Effects that the base has from the beginning.
    steps : tuple of Step
        What was added.
    own : tuple of Effect
        Effects of the user.
    """

    source: Model | str | tuple[str, ...] | Structure
    campaign: Campaign
    system: System
    floor: float
    begun: tuple[str, ...] = ()
    steps: tuple[Step, ...] = ()
    own: tuple[Effect, ...] = ()

    @property
    def given(self) -> tuple[str, ...]:
        """Effects that the base has now."""
        return (*self.begun, *(step.effect for step in self.steps))

    def diagnose(self, seed: int = 0) -> Diagnosis:
        """What the base, with the effects added so far, still lacks."""
        return answer(self.system, self.given, floor=self.floor, seed=seed)

    def add(self, effect: str | Finding | Step, why: str = "") -> Session:
        """A session with one effect more.

        Parameters
        ----------
        effect : str, Finding or Step
            Its name, or a finding of `diagnose` or a step of another session, whose odds are kept.
        why : str
            A remark.

        Raises
        ------
        UnknownNameError
            If no such effect takes part.
        ModelError
            If the base has it already.
        """
        name = effect if isinstance(effect, str) else effect.effect
        if name in self.given:
            raise ModelError(f"The model has {name} already.")
        kinds = {block.candidate.name: block.candidate.kind for block in self.system.blocks}
        if name not in kinds:
            raise no_such_effect(name, list(kinds))
        step = Step(
            action="fault_corrected" if kinds[name] == "fault" else "effect_added",
            effect=name,
            log_odds=None if isinstance(effect, str) else effect.log_odds,
            note=why,
        )
        return replace(self, steps=(*self.steps, step))

    def undo(self) -> Session:
        """The session before the last step.

        Raises
        ------
        ModelError
            If there is no step.
        """
        if not self.steps:
            raise ModelError("There is no step to undo.")
        return replace(self, steps=self.steps[:-1])

    @cached_property
    def blocks(self) -> tuple[Block, ...]:
        """The effects of the base at the values of their nonlinear parameters."""
        return refined(self.system, taken_as_given(self.system, self.given).blocks)

    def fall(self) -> ErrorFall:
        """Held-out errors of the base and after each step."""
        blocks = self.blocks
        first = len(self.begun)
        names = (BASE, *(step.effect for step in self.steps))
        return ErrorFall(
            steps=names,
            errors=tuple(
                held_out(self.system, blocks[: first + number]) for number in range(len(names))
            ),
        )

    def model(self) -> Model:
        """The model with base and effects fitted together, and with a step per effect.

        Raises
        ------
        ModelError
            If the base is a structure: it has no ship to sail with.
        """
        if not isinstance(self.source, Model):
            raise ModelError(
                f"The base {self.source!r} is a list of derivatives. Begin with a model: reduce "
                f"the campaign first, then take its model.toml."
            )
        blocks = self.blocks
        fit = joint_fit(self.system, blocks, floor=self.floor)
        found = refitted(self.source, fit, blocks, self.system.base, self.campaign, self.own)
        made = found.model.with_(notes=tuple(dict.fromkeys((*found.model.notes, *found.notes))))
        return made.stepped(*self._fitted(fit, blocks, self.source, made))

    def _fitted(
        self, fit: JointFit, blocks: Sequence[Block], old: Model, new: Model
    ) -> tuple[Step, ...]:
        """The steps with what the fit says of each."""
        plain = Step(
            action="fitted",
            campaign=self.campaign.title or self.campaign.ship.name,
            count=fit.std.size,
            Fn=froude_numbers(self.campaign),
            faults=tuple(x.candidate.name for x in blocks if x.candidate.kind == "fault"),
        )
        if not self.steps:
            return (plain,)
        errors = [item.share() for item in self.fall().errors]
        steps = []
        brought: set[str] = set()
        for number, step in enumerate(self.steps):
            block = blocks[len(self.begun) + number]
            c = block.candidate
            kept = c.kind == "physics" and old.convention == new.convention
            places = [x for x in places_of(block, new, self.own) if x not in brought]
            brought.update(places)
            values = dict(zip(c.coefficients, coefficients_of(block, fit)[0], strict=True))
            steps.append(
                replace(
                    plain,
                    action=step.action,
                    effect=step.effect,
                    coefficients={name: x for name, x in values.items() if math.isfinite(x)},
                    system="prime" if c.kind == "physics" else "",
                    parameter=c.parameter,
                    value=block.value if c.parameter else None,
                    log_odds=step.log_odds,
                    note=step.note,
                    error_before=_finite(errors[number]),
                    error_after=_finite(errors[number + 1]),
                    before=before_of(old, new, places) if kept else None,
                )
            )
        return tuple(steps)

    def _headline(self) -> str:
        named = (
            counted(len(self.source), "derivative")
            if isinstance(self.source, tuple)
            else getattr(self.source, "name", self.source)
        )
        steps = f" + {' + '.join(self.given)}" if self.given else ""
        return f"{named}{steps} on {counted(len(self.campaign), 'run')} of {self.campaign.title}"

    def _sections(self) -> Sequence[Section]:
        steps = [_told(step) for step in self.steps] or ["none yet: diagnose, then add"]
        asked = len(self.system.blocks) - len(self.given)
        return [
            Section(
                paragraphs=[
                    f"What is smooth and below {100 * self.floor:g} % of a channel's rms force is "
                    f"left alone; {counted(asked, 'candidate')} are asked.",
                    *([f"The base began with: {', '.join(self.begun)}."] if self.begun else []),
                ]
            ),
            Section(title="Steps", points=steps),
        ]

    def save(self, path: str | Path) -> None:
        """Write the steps as TOML, all or nothing; `replay` carries them out again."""
        data: dict[str, Any] = {
            "session": {"campaign": self.campaign.title, "floor": self.floor},
            "steps": [entries(step) for step in self.steps],
        }
        write_text(Path(path), toml_text(data))


def _told(step: Step) -> str:
    """An effect that was added, and why."""
    evidence = "" if step.log_odds is None else f"evidence {odds(step.log_odds)}"
    why = "; ".join(text for text in (evidence, step.note) if text)
    return f"{step.effect}: {why}" if why else step.effect


def begin(
    model: Model | str | Path | Sequence[str] | Structure,
    campaign: Campaign,
    *,
    floor: float | None = None,
    candidates: Sequence[Candidate] | None = None,
    noise: float | None = None,
    own: Sequence[Effect] = (),
) -> Session:
    """A session about a model and captive tests.

    Parameters
    ----------
    model : Model, str, path, sequence of str or Structure
        As for `diagnose`.
    campaign : Campaign
        Captive tests with histories.
    floor, candidates, noise, own
        As for `diagnose_captive`.

    Returns
    -------
    Session

    Raises
    ------
    DataError
        If the campaign is free-running, or holds no run with a known noise.
    """
    base = derivatives_of(model)
    system = captive_system(
        campaign, base.structure, floor=floor, candidates=candidates, noise=noise, own=own
    )
    begun = system.taking_part(base.effects)
    return Session(
        source=base.source,
        campaign=campaign,
        system=system.whole(begun),
        floor=system.floor,
        begun=begun,
        own=tuple(own),
    )


def replay(
    path: str | Path,
    model: Model | str | Path | Sequence[str] | Structure,
    campaign: Campaign,
    *,
    candidates: Sequence[Candidate] | None = None,
    noise: float | None = None,
    own: Sequence[Effect] = (),
) -> Session:
    """The steps of a file carried out again on a model and a campaign.

    Parameters
    ----------
    path : str or path
        Written by `Session.save`. Nothing in it is executed.
    model, campaign, candidates, noise, own
        As for `begin`.

    Raises
    ------
    ModelError
        If the file is damaged or of another kind.
    """
    saved = read_session(path)
    session = begin(model, campaign, floor=saved.floor, candidates=candidates, noise=noise, own=own)
    for step in saved.steps:
        session = session.add(step, step.note)
    return session


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


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
        least = FREE_FLOOR if floor is None else floor
        return fit_to_records(loaded, campaign, floor=least).model
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
    last = last_added(model.steps)
    if last is None:
        raise ModelError(f"The history of {model.name} knows of no effect that was added.")
    step = model.steps[last]
    if step.action == "fault_corrected":
        bare = model
    elif step.before is None:
        bare = without_effect(
            model, next((item for item in own if item.name == step.effect), step.effect)
        )
    else:
        bare = restored(model, step.before)
    return bare.with_(steps=(*model.steps[:last], *model.steps[last + 1 :])), step.effect
