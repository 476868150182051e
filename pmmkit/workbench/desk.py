"""What a server holds: the state on disk, long work, what was worked out, its command lines."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from threading import Lock, Thread
from typing import Any, Final

from pmmkit.base import DataError, PmmkitError, __version__
from pmmkit.campaigns import Campaign
from pmmkit.conventions import STRUCTURES, Criterion
from pmmkit.diagnosis import read_session
from pmmkit.effects import CATALOGUE, own_effect
from pmmkit.files import datasets_folder
from pmmkit.models import Model, load_model, load_ship, ships
from pmmkit.views import page_of, trials_page
from pmmkit.workbench.campaigns import AnswerCache, OpenCampaigns
from pmmkit.workbench.saved import (
    OPENED,
    OWN,
    STEPS,
    WorkbenchState,
    find_result,
    find_state,
    model_file,
    of_campaign,
    own_of,
    save_own,
    save_state,
    steps_of,
)
from pmmkit.workbench.tasks import RESULT, Work, find_rivals, tasks
from pmmkit.workbench.worker import Job, Worker

# The command line of each step: what a person would type to get the same.


Actions = Callable[[str], Any]
"""The actions by their names: whoever opens a page gives them, the page knows none by itself."""


def _reduced(model: str) -> bool:
    """Whether a base is reduced from the tests: a structure, or nothing, is named."""
    return not model or model in STRUCTURES


def command_lines(state: WorkbenchState, folder: Path, action: Actions) -> list[dict[str, str]]:
    """What was done so far, as commands."""
    tests = tuple(map(Path, state.campaigns))
    data = Path(state.data) if state.data else None
    own = folder / OWN if (folder / OWN).is_file() else None
    found: list[dict[str, str]] = []

    def add(what: str, effect: str = "", name: str = "", **settings: Any) -> None:
        line = action(name or what).typed(**settings)
        found.append({"what": what, "effect": effect, "line": line})

    base = state.model
    if _reduced(base):
        reduced = folder / "reduced"
        add(
            "reduce",
            campaign=tests[0],
            structure=base or None,
            fn="pooled",
            parts=state.parts or None,
            force=_by_force(model_file(folder, ())),
            out=reduced,
            data=data,
        )
        base = str(reduced / "model.toml")
    add("compare", model=base, campaigns=tests, data=data)
    told: dict[str, Any] = {"data": data, "own": own, **state.settings}
    add("diagnose", model=base, campaigns=tests, **told)
    told["fit"] = tests
    model = base
    for number, step in enumerate(state.steps, start=1):
        made = model_file(folder, state.effects[:number])
        named = ("@".join(filter(None, (step.effect, step.campaign))),)
        add("add", step.effect, model=model, effects=named, output=made, why=step.note, **told)
        model = str(made)
    if state.steps:
        steps, made = folder / STEPS, Path("replayed.toml")
        add("replay", name="add", model=base, steps=steps, output=made, **told)
    return found


def _by_force(base: Path) -> bool:
    """Whether a base was made of derivatives that are not usable, as the page does and says."""
    return base.is_file() and bool(load_model(base).not_usable)


DEMONSTRATION: Final = ("s175", "cubic", "s175-3dof")
"""Campaign, structure of the base, and ship that lends propeller and rudder."""


class StaleRevision(DataError):
    """Another page has changed the state meanwhile."""


class Desk:
    """The state of a workbench, changed by one request at a time and saved at each change.

    Parameters
    ----------
    folder : Path
        Of the workbench: state, steps, models and results.
    roots : sequence of Path
        Folders that were named: nothing else is read.
    action : callable
        The actions by their names: forms and command lines of the page are made from them.
    """

    def __init__(self, folder: Path, roots: Sequence[Path], action: Actions) -> None:
        self.folder = folder
        self.action = action
        self.roots = tuple(root.resolve() for root in roots)
        self._state = find_state(folder)
        self._changing = Lock()
        self.known = AnswerCache()
        self._open = OpenCampaigns(folder, self.named, self.known)
        self._worker = Worker(tasks, self._finished)

    @property
    def state(self) -> WorkbenchState | None:
        """What was opened, and the steps."""
        return self._state

    @property
    def structure(self) -> str:
        """To which tests are reduced where no model is named."""
        return str(self.action("reduce").default("structure"))

    @property
    def job(self) -> Job:
        """How the long work stands."""
        return self._worker.job

    def close(self) -> None:
        """End the process for long work."""
        self._worker.close()

    def resume(self) -> None:
        """Go on with what was saved; tests that were not yet open when the server ended are opened
        again."""
        state = self._state
        if state is not None and not self._ready(state):
            self.open(state)
        self.warm()

    def warm(self) -> None:
        """Work out in the background what is looked at first."""

        def work() -> None:
            # An error is told where the page asks for the same.
            with suppress(PmmkitError):
                self.misfit()
                self.turns()

        self._worker.warm()
        if self._state is not None and self._ready(self._state):
            Thread(target=work, daemon=True).start()

    # What is asked --------------------------------------------------------------------------------

    def page(self) -> dict[str, Any]:
        """The state as the page reads it."""
        state, job = self._state, self._worker.job
        page: dict[str, Any] = {
            "version": __version__,
            "job": job.to_dict(),
            "demonstration": str(datasets_folder() / DEMONSTRATION[0]),
            "opened": False,
            "structures": sorted(STRUCTURES),
            "ships": sorted(ships()),
            "titles": CATALOGUE.titles,
            "revision": -1,
        }
        if state is None:
            return page
        ready = self._ready(state)
        page |= {
            "opened": ready,
            "revision": state.revision,
            "campaign": state.campaign,
            "also": list(state.also),
            "model": state.model or self.structure,
            "folder": str(self.folder),
            "steps": [
                {
                    "effect": step.effect,
                    "campaign": step.campaign,
                    "action": step.action,
                    "note": step.note,
                }
                for step in state.steps
            ],
            "commands": command_lines(state, self.folder, self.action),
        }
        return page | self._about(state) if ready else page

    def _about(self, state: WorkbenchState) -> dict[str, Any]:
        """Of the tests that are open; what is damaged is told beside what is not."""
        page: dict[str, Any] = {
            "title": ", ".join(Path(place).name for place in state.campaigns),
            "ship": "",
            "kind": "captive",
            "runs": 0,
            "campaigns": [],
            **self._own(),
            "faults": [],
            "outdated": False,
            "asked": find_result(self.folder, "missing", state.effects) is not None,
        }
        try:
            every = self._open.every(state)
            ship = self._open.sailing(state)
            reduced = find_result(self.folder, OPENED, ())
            made = [item.provenance.get("sha256") for item in every.values()]
            page |= {
                "title": ", ".join(every),
                "ship": ship.ship.name,
                "kind": ship.kind,
                "runs": sum(map(len, every.values())),
                "campaigns": [
                    {"title": name, "kind": item.kind, "runs": len(item)}
                    for name, item in every.items()
                ],
                "outdated": reduced not in (None, made),
            }
        except PmmkitError as error:
            page["faults"].append(str(error))
        return page

    def misfit(self, count: int | None = None, of: int = 0) -> dict[str, Any]:
        """The map of runs of a campaign, with the model after so many steps."""
        state, effects = self._opened(), self._effects(count)
        found: dict[str, Any] = self.known.once(
            ("misfit", effects, of), lambda: page_of(self._open.comparison(state, effects, of))
        )
        return found

    def history(
        self, run: str, count: int | None = None, buckets: int | None = None, of: int = 0
    ) -> dict[str, Any]:
        """One run of a campaign, measured and modelled."""
        state, effects = self._opened(), self._effects(count)
        try:
            comparison = self._open.comparison(state, effects, of)
            return page_of(comparison, run=run, buckets=buckets)
        except KeyError:
            raise DataError(f"No run {run!r} was compared.") from None

    def checks(self, of: int = 0) -> list[dict[str, Any]]:
        """What the checks say of the tests."""
        found: list[dict[str, Any]] = find_result(self.folder, of_campaign("checks", of), ()) or []
        return found

    def runs(self, first: int, of: int = 0) -> dict[str, Any]:
        """Some of the runs as they were read."""
        tests = self._open.campaign(self._opened(), of)
        page: dict[str, Any] = self.known.once(
            ("runs", first, of), lambda: page_of(tests, self.checks(of), first=first)
        )
        return page

    def record(self, run: str, of: int = 0) -> dict[str, Any]:
        """One run as it was read, with what counts of it."""
        state = self._opened()
        tests = self._open.campaign(state, of)
        page: dict[str, Any] = self.known.once(
            ("record", run, of, self._open.stamp(state, of)),
            lambda: page_of(tests, self.checks(of), run=run),
        )
        return page

    def derivatives(self, of: int = 0) -> dict[str, Any] | None:
        """The derivatives of the tests; None where they were not asked for."""
        found: dict[str, Any] | None = find_result(self.folder, of_campaign("derivatives", of), ())
        return found

    def missing(self) -> dict[str, Any] | None:
        """The last diagnosis, of this state or of one before; None where it was not asked.

        ``since`` counts the steps that were added after it. Then what was named and is not added
        yet is left, without numbers: those were of a model that lacked more.
        """
        effects = self._opened().effects
        for count in range(len(effects), -1, -1):
            found = find_result(self.folder, "missing", effects[:count])
            if found is not None:
                return {**found, **_left(found, effects[count:])}
        return None

    def fall(self) -> dict[str, Any] | None:
        """The waterfall; None before the first step."""
        found: dict[str, Any] | None = self._result("fall")
        return found

    def turns(self) -> dict[str, Any]:
        """The turning circle of the base and of the model with all steps."""
        state = self._opened()
        chosen = {"before": (), "after": state.effects} if state.steps else {"before": ()}
        return {
            name: self.known.once(("turn", own), partial(self._turn, own))
            for name, own in chosen.items()
        }

    def sail(self, asked: Mapping[str, Any]) -> dict[str, Any]:
        """A manoeuvre of the present model with settings of sliders."""
        model = self._model(self._opened().effects)
        settings = {name: value for name, value in asked.items() if value is not None}
        manoeuvre, speed = str(settings.pop("manoeuvre")), float(settings.pop("speed"))
        own = self._opened().effects
        drawn = manoeuvre != "spiral" and settings.get("band")
        rivals = find_rivals(self.folder, own) if drawn else ()
        return page_of(model, manoeuvre, speed=speed, rivals=rivals, **settings)

    def trials(self) -> dict[str, list[dict[str, Any]]]:
        """Measured turns and zigzags of the tests, by manoeuvre; none of captive tests."""
        state = self._opened()
        length = self._model(state.effects).ship.L
        found: dict[str, list[dict[str, Any]]] = {}
        for of, tests in enumerate(self._open.every(state).values()):
            if tests.kind == "captive":
                continue
            comparison = self._open.comparison(state, state.effects, of)
            for name, own in trials_page(comparison.manoeuvres, length).items():
                found.setdefault(name, []).extend(own)
        return found

    def range(self) -> dict[str, Any]:
        """What the sliders of the ship reach."""
        state = self._opened()
        model = self._model(state.effects)
        tests = self._open.sailing(state)
        water = tests.water.g
        Fn = sorted({tests.ship.froude(run.settings.speed, water) for run in tests.runs})
        speeds = [model.ship.speed(x, model.water.g) for x in Fn]
        return {
            "speeds": [round(x, 3) for x in speeds],
            "L": model.ship.L,
            "draught": model.ship.d,
            "windy": any("wind_speed" in part.known.needs for part in model.parts.values()),
            "shallow": model.feels("depth"),
            "scale": model.scale,
            "parts": state.parts,
            "lenders": self._lenders(state),
        }

    def _lenders(self, state: WorkbenchState) -> list[str]:
        """Library ships of the same form, whose propeller and rudder a reduced base may have."""
        if not _reduced(state.model):
            return []
        tested = self._open.sailing(state).ship
        return [name for name in ships() if not load_ship(name).form_apart(tested)]

    # What is done ---------------------------------------------------------------------------------

    def open(self, asked: WorkbenchState) -> Job:
        """Open tests and a base; a base that is a structure, or none, is reduced from the tests."""
        with self._changing:
            model = asked.model
            places = [self.named(campaign) for campaign in asked.campaigns]
            for campaign, place in zip(asked.campaigns, places, strict=True):
                if not place.exists():
                    raise DataError(f"{campaign}: there is no such file or folder.")
            if len(set(places)) < len(places):
                raise DataError("A campaign is named twice: name another one of the same ship.")
            for name in (model, asked.parts):
                if name and name not in STRUCTURES and name not in ships():
                    self.named(name)
            if asked.parts and not _reduced(model):
                raise DataError(f"{model} has its own parts: {asked.parts} lends to a structure.")
            if _lent(places[0]) and not model:
                model = DEMONSTRATION[1]
            lent = asked.parts or (_lent(places[0]) if _reduced(model) else "")
            revision = -1 if self._state is None else self._state.revision
            state = replace(asked, model=model, parts=lent, revision=revision + 1, steps=())
            more = {"model": model or self.structure, "parts": lent or None}
            job = self._worker.start("open", self._asked(asked) | more)
            self.folder.mkdir(parents=True, exist_ok=True)
            for old in (*self.folder.glob("model_0*.toml"), *self.folder.glob("*_*.json")):
                old.unlink(missing_ok=True)
            self.known.clear()
            self._change(state)
            return job

    def beside(self, revision: int, campaign: str) -> Job:
        """Open another campaign of the same ship beside those that are open; steps begin anew."""
        state = self._current(revision)
        return self.open(replace(state, also=(*state.also, campaign)))

    def without(self, revision: int, of: int) -> Job:
        """Take a campaign off; steps begin anew with those that are left."""
        state = self._current(revision)
        self._open.place(state, of)
        left = [place for number, place in enumerate(state.campaigns) if number != of]
        if not left:
            raise DataError("The only campaign stays: open another one in its place.")
        return self.open(replace(state, campaign=left[0], also=tuple(left[1:])))

    def diagnose(self, revision: int) -> Job:
        """Ask what is missing."""
        with self._changing:
            return self._worker.start("diagnose", self._asked(self._current(revision)))

    def again(self, revision: int, parts: str | None = None) -> Job:
        """Do anew what depends on the campaign file: the base, each step, the derivatives; with
        propeller and rudder of another ship where one is named, of none where it is empty."""
        with self._changing:
            state = self._current(revision)
            if parts is not None:
                lenders = self._lenders(state)
                if parts and parts not in lenders:
                    can = f"these can: {', '.join(lenders)}" if lenders else "no ship here can"
                    raise DataError(f"{parts} cannot lend propeller and rudder; {can}.")
                state = replace(state, parts=parts)
            more = {"model": state.model or self.structure, "parts": state.parts or None}
            return self._worker.start("again", self._asked(state) | more)

    def correct(
        self, revision: int, run: str, write: Callable[[Campaign, str], None], of: int = 0
    ) -> None:
        """Change what the campaign file says of a run, by a function of campaign and run.

        Raises
        ------
        DataError
            If it cannot be written, with the reason.
        """
        with self._changing:
            state = self._current(revision)
            self._idle()
            write(self._open.campaign(state, of), run)
            self._open.campaign(state, of)
            self._change(replace(state, revision=state.revision + 1))

    def check(self, name: str, text: str) -> dict[str, Any]:
        """What an effect of one's own would have as coefficients, with their usual sizes, or what
        of its text cannot be read: a text that is being typed is mostly wrong."""
        try:
            effect = own_effect(name, text)
        except DataError as error:
            return {"error": str(error)}
        sizes = [{"name": key, "typical": size} for key, size in effect.typical.items()]
        return {"coefficients": sizes}

    def write(self, revision: int, name: str, text: str) -> Job:
        """Keep an effect of one's own, new or rewritten, and ask what is missing with it."""
        with self._changing:
            state = self._current(revision)
            if name in state.effects:
                raise DataError(f"{name} is in the model: undo it before you rewrite it.")
            effect = own_effect(name, text)
            others = [item for item in own_of(self.folder) if item.name != name]
            self._idle()
            save_own(self.folder, [*others, effect])
            for name in ("missing", RESULT):
                for old in self.folder.glob(f"{name}_*.json"):
                    old.unlink(missing_ok=True)
            self._change(replace(state, revision=state.revision + 1))
            return self._worker.start("diagnose", self._asked(state))

    def reduce(self, structure: str, of: int = 0) -> Job:
        """Derivatives of a campaign by a structure."""
        if structure not in STRUCTURES:
            raise DataError(f"There is no structure {structure!r}.")
        with self._changing:
            state = self._opened()
            self._open.place(state, of)
            more = {"structure": structure, "of": of}
            return self._worker.start("reduce", self._asked(state) | more)

    def add(self, revision: int, effect: str, why: str = "", campaign: str = "") -> Job:
        """Add an effect, or correct a fault, of several campaigns the one that has it."""
        with self._changing:
            state = self._current(revision)
            shown = self._candidate(effect, campaign)
            if not shown.get("offered", True):
                raise DataError(f"{effect} does not help. {shown['reason']}")
            more = {
                "effect": effect,
                "why": why.strip(),
                "of": campaign,
                "log_odds": shown["log_odds"] if shown.get("named") else None,
            }
            return self._worker.start("add", self._asked(state) | more)

    def undo(self, revision: int) -> None:
        """Take the last step back."""
        with self._changing:
            state = self._current(revision)
            self._idle()
            if not state.steps:
                raise DataError("There is no step to undo.")
            left = state.steps[:-1]
            saved = read_session(self.folder / STEPS)
            replace(saved, steps=left).save(self.folder / STEPS)
            self._change(state.with_steps(left))

    def opened_at(self, of: int = 0) -> tuple[Path, str]:
        """Where the tests lie that are open, and the folder of their measurements."""
        state = self._opened()
        return self._open.place(state, of), state.data

    @contextmanager
    def writing(self) -> Iterator[None]:
        """While something is written, nothing else is changed."""
        with self._changing:
            yield

    def wait(self, say: Callable[[str], None]) -> None:
        """Wait for the long work.

        Raises
        ------
        DataError
            If it fails.
        """
        told = ""
        while (job := self._worker.job).stand == "running":
            if job.text != told:
                told = job.text
                say(told)
            time.sleep(0.05)
        if job.stand == "failed":
            raise DataError(job.text)

    def cancel(self) -> Job:
        """End the long work."""
        return self._worker.cancel()

    def named(self, path: str) -> Path:
        """A path inside one of the folders that were named.

        Raises
        ------
        DataError
            If it is not.
        """
        try:
            place = Path(path).resolve()
        except (OSError, ValueError) as error:
            raise DataError(f"{path!r} is no path.") from error
        allowed = (*self.roots, self.folder.resolve(), datasets_folder().resolve())
        if not any(place.is_relative_to(root) for root in allowed):
            listed = ", ".join(map(str, self.roots))
            raise DataError(
                f"{path} is outside the folders that were named ({listed}). Name its folder: "
                f"pmmkit workbench --folder FOLDER."
            )
        return place

    # What stands behind ---------------------------------------------------------------------------

    def _own(self) -> dict[str, Any]:
        """Effects of one's own, or why their file cannot be read."""
        try:
            own = own_of(self.folder)
        except PmmkitError as error:
            return {"own": [], "own_error": str(error)}
        return {"own": [{"name": x.name, "text": x.text} for x in own], "own_error": ""}

    def _idle(self) -> None:
        if self._worker.job.stand == "running":
            raise DataError("Something is being worked out: wait for it, or cancel it.")

    def _finished(self, job: Job) -> None:
        if job.name == "add":
            with self._changing:
                effects = (*job.asked["work"].effects, job.asked["effect"])
                self._change(self._opened().with_steps(steps_of(self.folder, effects)))
        if job.name == "again":
            with self._changing:
                state = self._opened()
                parts = job.asked["parts"] or ""
                self._change(replace(state, parts=parts, revision=state.revision + 1))
        # After a step the page asks itself, the waterfall first.
        if job.name in ("open", "again"):
            self.known.clear()
            self.warm()

    def _result(self, name: str) -> Any:
        return find_result(self.folder, name, self._opened().effects)

    def _change(self, state: WorkbenchState) -> None:
        save_state(self.folder, state)
        self._state = state

    def _ready(self, state: WorkbenchState) -> bool:
        return model_file(self.folder, state.effects).is_file()

    def _opened(self) -> WorkbenchState:
        if self._state is None or not self._ready(self._state):
            raise DataError("Nothing is open yet: choose the demonstration or a campaign.")
        return self._state

    def _current(self, revision: int) -> WorkbenchState:
        state = self._opened()
        if revision != state.revision:
            raise StaleRevision("Another page has changed the steps: this one shows them now.")
        return state

    def _asked(self, state: WorkbenchState) -> dict[str, Any]:
        work = Work(
            folder=self.folder,
            campaigns=tuple(str(self.named(place)) for place in state.campaigns),
            data=state.data,
            settings=state.settings,
            effects=state.effects,
        )
        return {"work": work}

    def _candidate(self, effect: str, campaign: str) -> Mapping[str, Any]:
        """What the page shows of a candidate; nothing where it shows none of this name."""
        shown = (self.missing() or {}).get("candidates", ())
        mine = (x for x in shown if (x["effect"], x.get("campaign", "")) == (effect, campaign))
        return next(mine, {})

    def _effects(self, count: int | None) -> tuple[str, ...]:
        effects = self._opened().effects
        return effects if count is None else effects[: max(count, 0)]

    def _model(self, effects: tuple[str, ...]) -> Model:
        return load_model(model_file(self.folder, effects))

    def _turn(self, effects: tuple[str, ...]) -> dict[str, Any]:
        model, reach = self._model(effects), self.range()["speeds"]
        speed = reach[len(reach) // 2]
        settings: dict[str, Any] = {"rudder_deg": Criterion.HARD_OVER, "extrapolate": True}
        return page_of(model, "turning", speed=speed, band=True, **settings)


def _lent(place: Path) -> str:
    """Ship that lends propeller and rudder where none is named: that of the demonstration alone."""
    return DEMONSTRATION[2] if place == (datasets_folder() / DEMONSTRATION[0]).resolve() else ""


def _left(found: dict[str, Any], added: Sequence[str]) -> dict[str, Any]:
    """What of a diagnosis still holds when some effects were added after it."""
    if not added:
        return {"since": 0}
    left = [
        {**item, "share": None, "lost": False}
        for item in found["candidates"]
        if item["named"] and item["effect"] not in added
    ]
    return {
        "since": len(added),
        "candidates": left,
        "sets": [],
        "suspected": [],
        "overlays": {},
        "base": {},
        "drawn": None,
    }
