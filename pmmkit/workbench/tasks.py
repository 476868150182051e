"""Long work: opening tests and a base, asking what is missing, adding effects, keeping rivals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from pmmkit.base import DataError, ModelError
from pmmkit.campaigns import Campaign, open_campaign
from pmmkit.conventions import STRUCTURES
from pmmkit.diagnosis import Diagnosis, Session, SeveralCampaigns, Together, begin, carried
from pmmkit.intake import CheckFinding, examine, refuse
from pmmkit.models import Model, load_model, save_model
from pmmkit.views import page_of
from pmmkit.workbench.saved import (
    OPENED,
    STEPS,
    find_result,
    model_file,
    of_campaign,
    own_of,
    save_result,
    steps_of,
)
from pmmkit.workbench.worker import Tell

if TYPE_CHECKING:
    from pmmkit.workbench.worker import Task


# Ships that the tests accept: the sets that a diagnosis named, kept as models.


RESULT: Final = "rivals"


def save_rivals(folder: Path, session: Session[Any], found: Diagnosis | Together) -> None:
    """Keep the sets that a diagnosis named and that can be sailed, each with its odds and ship."""
    effects = tuple(step.effect for step in session.steps)
    kept: list[dict[str, Any]] = []
    for names, odds in found.group:
        file = folder / f"rival_{len(effects)}_{len(kept)}.toml"
        with suppress(ModelError):
            save_model(session.evidence.rival(session.steps, names), file)
            kept.append({"effects": names, "odds": odds, "file": file.name})
    save_result(folder, RESULT, effects, kept)


def find_rivals(
    folder: Path, effects: tuple[str, ...]
) -> tuple[tuple[Model, float, tuple[str, ...]], ...]:
    """Ships that the tests accept beside the model with some effects: odds, and what it lacks then.

    They are those of the last diagnosis that named any, while what was added since is part of one
    of its sets; none after other steps.
    """
    for count in range(len(effects), -1, -1):
        found = find_result(folder, RESULT, effects[:count])
        if not found:
            continue
        if not any(set(effects[count:]) <= set(item["effects"]) for item in found):
            return ()
        return tuple(
            (load_model(folder / item["file"]), item["odds"], tuple(item["effects"]))
            for item in found
        )
    return ()


WHOLE: Final = 100
PARTS: Final = (30, 75)
"""How far of `WHOLE` a diagnosis is when tests are ready, and when the catalogue is weighed."""


def tasks() -> Mapping[str, Task]:
    """What the process for long work can do, by name."""
    own = Tasks()
    return {
        "open": own.open,
        "again": own.again,
        "diagnose": own.diagnose,
        "add": own.add,
        "reduce": own.reduce,
    }


@dataclass(frozen=True, kw_only=True)
class Work:
    """What long work is about.

    `campaigns`: paths of the tests. `data`: folder of their measurements, or nothing.
    `settings`: noise and floor, where they were given. `effects`: what was added to the base.
    """

    folder: Path
    campaigns: tuple[str, ...]
    data: str = ""
    settings: Mapping[str, float] = field(default_factory=dict)
    effects: tuple[str, ...] = ()


class Tasks:
    """What the process for long work does; it keeps the tests and the sessions that it has.

    All paths are those of a workbench's folder and of what it was opened with.
    """

    def __init__(self) -> None:
        self._campaigns: dict[tuple[str, str], Campaign] = {}
        self._sessions: dict[tuple[Any, ...], Session[Any]] = {}

    def open(self, work: Work, model: str, parts: str | None, *, tell: Tell) -> None:
        """Check the tests, and make the base where a structure is named."""
        tell(0, 0, "reading the tests")
        tests = self._tests(work)
        place = work.folder
        base, checked = self._base(tests, model, parts, tell)
        _save_base(place, tests, base)
        _save_checks(place, checked)
        save_result(place, OPENED, (), _stamps(tests))

    def again(self, work: Work, model: str, parts: str | None, *, tell: Tell) -> None:
        """Base, steps and derivatives from campaign files that were changed meanwhile."""
        place = work.folder
        known = {
            of: found["structure"]
            for of in range(len(work.campaigns))
            if (found := find_result(place, of_campaign("derivatives", of), ()))
        }
        steps = steps_of(place, work.effects)
        total = len(steps) + 2
        tell(0, total, "reading the tests")
        self._campaigns, self._sessions = {}, {}
        tests = self._tests(work)
        base, checked = self._base(tests, model, parts, tell)
        for old in place.glob("*_*.json"):
            old.unlink(missing_ok=True)
        save_result(place, OPENED, (), "")
        _save_base(place, tests, base)
        session = self._session(replace(work, effects=()), tell) if steps else None
        for number, step in enumerate(steps, start=1):
            tell(number + 1, total, f"fitting with {step.effect}")
            assert session is not None
            session = session.add(step, step.note)
            now = tuple(item.effect for item in session.steps)
            _save_models(place, now, session)
            save_result(place, "fall", now, page_of(session.fall()))
        if session is not None:
            session.save(place / STEPS)
        _save_checks(place, checked)
        for of, structure in known.items():
            self.reduce(work, structure, of, tell=tell)
        save_result(place, OPENED, (), _stamps(tests))

    def diagnose(self, work: Work, *, tell: Tell) -> None:
        """What the base with these steps still lacks."""
        session = self._session(work, tell)
        tell(PARTS[0], WHOLE, "weighing the effects of the catalogue")
        found = session.diagnose()

        def heard(share: float, effect: str) -> None:
            done = PARTS[1] + round((WHOLE - PARTS[1]) * share)
            tell(done, WHOLE, f"what {effect} alone would do")

        page = page_of(found, session, heard)
        save_rivals(work.folder, session, found)
        save_result(work.folder, "missing", work.effects, page)

    def add(
        self, work: Work, effect: str, why: str, of: str, log_odds: float | None, *, tell: Tell
    ) -> None:
        """One effect more: the model, its errors and the steps, written to the folder."""
        session = self._session(work, tell)
        tell(PARTS[0], WHOLE, f"fitting with {effect}")
        session = session.add(effect, why, campaign=of, log_odds=log_odds)
        place, now = work.folder, tuple(step.effect for step in session.steps)
        if of:
            # What is kept is told by the names of the steps: another campaign had this fault.
            for old in place.glob(f"*_{len(now)}.json"):
                old.unlink(missing_ok=True)
        _save_models(place, now, session)
        tell(PARTS[1], WHOLE, "errors of what is left out")
        save_result(place, "fall", now, page_of(session.fall()))
        session.save(place / STEPS)

    def reduce(self, work: Work, structure: str, of: int, *, tell: Tell) -> None:
        """Derivatives of a campaign, a set per Froude number, and what determines them."""
        from pmmkit.reduction import reduce_campaign

        tests = self._campaign(work.campaigns[of], work.data)
        reduction = reduce_campaign(tests, structure=structure, progress=tell, executor=1)
        name = of_campaign("derivatives", of)
        save_result(work.folder, name, (), page_of(reduction))

    def _campaign(self, path: str, data: str) -> Campaign:
        if (path, data) not in self._campaigns:
            self._campaigns[path, data] = open_campaign(path, data=data or None)
        return self._campaigns[path, data]

    def _tests(self, work: Work) -> dict[str, Campaign]:
        """The campaigns by their titles."""
        return Campaign.by_title([self._campaign(path, work.data) for path in work.campaigns])

    def _base(
        self, tests: Mapping[str, Campaign], model: str, parts: str | None, tell: Tell
    ) -> tuple[Model, list[tuple[CheckFinding, ...]]]:
        """The base, and what the checks say of each campaign: of the one that it is reduced from
        what the reduction says, so that nothing is read twice."""
        if model not in STRUCTURES:
            return load_model(model), [_sound(item) for item in tests.values()]
        first = next((name for name, item in tests.items() if item.kind == "captive"), None)
        if first is None:
            raise DataError("Records that run free need a model: a library ship or a model file.")
        found = {name: _sound(item) for name, item in tests.items() if name != first}
        from pmmkit.api import model_of
        from pmmkit.reduction import reduce_campaign

        reduction = reduce_campaign(
            tests[first], structure=model, fn="pooled", progress=tell, executor=1
        )
        found[first] = reduction.findings
        # Whoever opens it asks what is wrong: a model by force says so wherever it sails.
        return model_of(reduction, parts, force=True), [found[name] for name in tests]

    def _session(self, work: Work, tell: Tell) -> Session[Any]:
        """The session of these steps; the tests are looked at once."""
        base = model_file(work.folder, ())
        own = own_of(work.folder)
        texts = [(item.name, item.text) for item in own]
        stamp = f"{base}:{base.stat().st_mtime_ns}:{sorted(work.settings.items())}:{texts}"
        key = (work.campaigns, work.data, stamp, work.effects)
        if key not in self._sessions:
            first = (*key[:-1], ())
            if first not in self._sessions:
                tell(0, WHOLE, "reading the tests")
                tests = self._tests(work)
                free = any(item.kind == "free-running" for item in tests.values())
                heard = {"progress": partial(tell, 0, 0)} if free or len(tests) > 1 else {}
                given: dict[str, Any] = {**work.settings, **heard}
                asked = tests if len(tests) > 1 else next(iter(tests.values()))
                self._sessions[first] = begin(load_model(base), asked, own=own, **given)
            session = self._sessions[first]
            for step in steps_of(work.folder, work.effects):
                session = session.add(step, step.note)
            self._sessions[key] = session
        return self._sessions[key]


def _sound(tests: Campaign) -> tuple[CheckFinding, ...]:
    """What the checks say of tests; refused where they contradict themselves."""
    found = examine(tests)
    refuse(found)
    return found


def _save_checks(place: Path, checked: Sequence[Sequence[CheckFinding]]) -> None:
    for of, own in enumerate(checked):
        save_result(place, of_campaign("checks", of), (), [item.to_dict() for item in own])


def _save_base(place: Path, tests: Mapping[str, Campaign], base: Model) -> None:
    """Keep the base, of several campaigns at the length that each has tested; the ship is that of
    the first that sails free."""
    if len(tests) == 1:
        save_model(base, model_file(place, ()))
        return
    free = {name: x for name, x in tests.items() if x.kind == "free-running"}
    made = {name: carried(base, name, item)[0] for name, item in free.items()}
    ship = next(iter(made.values()), base)
    save_model(ship, model_file(place, ()))
    for of, name in enumerate(tests):
        save_model(made.get(name, ship), model_file(place, (), of))


def _save_models(place: Path, effects: tuple[str, ...], session: Session[Any]) -> None:
    """Keep the ship with all steps, and as each of several campaigns has it."""
    evidence = session.evidence
    if not isinstance(evidence, SeveralCampaigns):
        save_model(session.model(), model_file(place, effects))
        return
    models = evidence.models(session.steps)
    save_model(models[evidence.ship], model_file(place, effects))
    for of, model in enumerate(models.values()):
        save_model(model, model_file(place, effects, of))


def _stamps(tests: Mapping[str, Campaign]) -> list[Any]:
    """By which campaign files these are known again."""
    return [item.provenance.get("sha256") for item in tests.values()]
