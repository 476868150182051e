"""Long work: opening tests and a base, asking what is missing, adding effects."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from pmmkit.campaigns.file.campaign_file import open_campaign
from pmmkit.campaigns.run import Campaign
from pmmkit.checks import examine, refuse
from pmmkit.errors import DataError
from pmmkit.loop import Session, begin
from pmmkit.models import Model, load_model, save_model
from pmmkit.structures import structures
from pmmkit.workbench.pages.fall import fall_page
from pmmkit.workbench.pages.missing import missing_page
from pmmkit.workbench.rivals import save_rivals
from pmmkit.workbench.saved import (
    OPENED,
    STEPS,
    find_result,
    model_file,
    own_of,
    save_result,
    steps_of,
)
from pmmkit.workbench.worker import Tell

if TYPE_CHECKING:
    from pmmkit.workbench.worker import Task

STRUCTURE: Final = "abkowitz3"
"""Structure of the base where no model is named."""
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


class Tasks:
    """What the process for long work does; it keeps the tests and the sessions that it has.

    All paths are those of a workbench's folder and of what it was opened with.
    """

    def __init__(self) -> None:
        self._campaigns: dict[tuple[str, str], Campaign] = {}
        self._sessions: dict[tuple[str, str, str, tuple[str, ...]], Session] = {}

    def open(
        self, folder: str, campaign: str, model: str, data: str, parts: str | None, *, tell: Tell
    ) -> None:
        """Check the tests, and make the base where a structure or nothing is named."""
        tell(0, 3, "reading the tests")
        tests = self._campaign(campaign, data)
        findings = examine(tests)
        refuse(findings)
        tell(1, 3, "the base")
        place = Path(folder)
        save_model(self._base(tests, model, parts), model_file(place, ()))
        save_result(place, "checks", (), [item.to_dict() for item in findings])
        save_result(place, OPENED, (), tests.provenance.get("sha256"))

    def again(
        self,
        folder: str,
        campaign: str,
        data: str,
        settings: Mapping[str, float],
        effects: Sequence[str],
        model: str,
        parts: str | None,
        *,
        tell: Tell,
    ) -> None:
        """Base, steps and derivatives from a campaign file that was changed meanwhile."""
        place = Path(folder)
        known = find_result(place, "derivatives", ())
        steps = steps_of(place, effects)
        total = len(steps) + 2
        tell(0, total, "reading the tests")
        tests = open_campaign(campaign, data=data or None)
        findings = examine(tests)
        refuse(findings)
        tell(1, total, "the base")
        base = self._base(tests, model, parts)
        self._campaigns = {(campaign, data): tests}
        self._sessions = {}
        for old in place.glob("*_*.json"):
            old.unlink(missing_ok=True)
        save_result(place, OPENED, (), "")
        save_model(base, model_file(place, ()))
        session = self._session(folder, campaign, data, settings, (), tell) if steps else None
        for number, step in enumerate(steps, start=1):
            tell(number + 1, total, f"fitting with {step.effect}")
            assert session is not None
            session = session.add(step, step.note)
            now = tuple(item.effect for item in session.steps)
            save_model(session.model(), model_file(place, now))
            save_result(place, "fall", now, fall_page(session.fall()))
        if session is not None:
            session.save(place / STEPS)
        save_result(place, "checks", (), [item.to_dict() for item in findings])
        if known:
            self.reduce(folder, campaign, data, known["structure"], tell=tell)
        save_result(place, OPENED, (), tests.provenance.get("sha256"))

    def diagnose(
        self,
        folder: str,
        campaign: str,
        data: str,
        settings: Mapping[str, float],
        effects: Sequence[str],
        *,
        tell: Tell,
    ) -> None:
        """What the base with these steps still lacks."""
        session = self._session(folder, campaign, data, settings, effects, tell)
        tell(PARTS[0], WHOLE, "weighing the effects of the catalogue")
        found = session.diagnose()

        def heard(share: float, effect: str) -> None:
            done = PARTS[1] + round((WHOLE - PARTS[1]) * share)
            tell(done, WHOLE, f"what {effect} alone would do")

        page = missing_page(session, found, heard)
        save_rivals(Path(folder), session, found)
        save_result(Path(folder), "missing", tuple(effects), page)

    def add(
        self,
        folder: str,
        campaign: str,
        data: str,
        settings: Mapping[str, float],
        effects: Sequence[str],
        effect: str,
        why: str,
        log_odds: float | None,
        *,
        tell: Tell,
    ) -> None:
        """One effect more: the model, its errors and the steps, written to the folder."""
        session = self._session(folder, campaign, data, settings, effects, tell)
        tell(PARTS[0], WHOLE, f"fitting with {effect}")
        session = session.add(effect, why)
        if log_odds is not None:
            last = replace(session.steps[-1], log_odds=log_odds)
            session = replace(session, steps=(*session.steps[:-1], last))
        place, now = Path(folder), tuple(step.effect for step in session.steps)
        save_model(session.model(), model_file(place, now))
        tell(PARTS[1], WHOLE, "errors of what is left out")
        save_result(place, "fall", now, fall_page(session.fall()))
        session.save(place / STEPS)

    def reduce(self, folder: str, campaign: str, data: str, structure: str, *, tell: Tell) -> None:
        """Derivatives of the tests, a set per Froude number, and what determines them."""
        from pmmkit.reduction import reduce_campaign
        from pmmkit.workbench.pages.derivatives import derivatives_page

        tests = self._campaign(campaign, data)
        reduction = reduce_campaign(tests, structure=structure, progress=tell, jobs=1)
        save_result(Path(folder), "derivatives", (), derivatives_page(reduction))

    def _campaign(self, path: str, data: str) -> Campaign:
        if (path, data) not in self._campaigns:
            self._campaigns[path, data] = open_campaign(path, data=data or None)
        return self._campaigns[path, data]

    def _base(self, tests: Campaign, model: str, parts: str | None) -> Model:
        if model and model not in structures():
            return load_model(model)
        if tests.kind != "captive":
            raise DataError("Records that run free need a model: a library ship or a model file.")
        from pmmkit.api import model_of
        from pmmkit.reduction import reduce_campaign

        reduction = reduce_campaign(tests, structure=model or STRUCTURE, fn="pooled")
        return model_of(reduction, parts)

    def _session(
        self,
        folder: str,
        campaign: str,
        data: str,
        settings: Mapping[str, float],
        effects: Sequence[str],
        tell: Tell,
    ) -> Session:
        """The session of these steps; the tests are looked at once."""
        base = model_file(Path(folder), ())
        own = own_of(Path(folder))
        texts = [(item.name, item.text) for item in own]
        stamp = f"{base}:{base.stat().st_mtime_ns}:{sorted(settings.items())}:{texts}"
        key = (campaign, data, stamp, tuple(effects))
        if key not in self._sessions:
            first = (campaign, data, stamp, ())
            if first not in self._sessions:
                tell(0, WHOLE, "reading the tests")
                tests = self._campaign(campaign, data)
                free = tests.kind == "free-running"
                heard = {"progress": partial(_heard, tell)} if free else {}
                given: dict[str, Any] = {**settings, **heard}
                self._sessions[first] = begin(load_model(base), tests, own=own, **given)
            session = self._sessions[first]
            for step in steps_of(Path(folder), effects):
                session = session.add(step, step.note)
            self._sessions[key] = session
        return self._sessions[key]


def _heard(tell: Tell, text: str) -> None:
    tell(0, 0, text)
