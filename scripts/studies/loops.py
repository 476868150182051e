"""The loop on captive tests of a virtual ship, by every way a user can go: where does it end?

    python -m scripts.studies.loops [--loops 20] [--first 0] [--ways command session given page]
                                    [--programme full] [--workers 2]

In each campaign a coupling of sway and yaw and a fault of the measurement are hidden; the base is
`cubic`, reduced from the same tests. Each way adds what the diagnosis proposes until it proposes
nothing more:

command : ``pmmkit diagnose``, then what its line ``Next:`` says, on the files it names.
session : `Session.diagnose`, then `Session.add` of each of `Diagnosis.proposed`.
given : ``pmmkit diagnose --given`` with all effects so far.
page : the workbench's actions, the candidate that stands first.

Printed: the steps, those that are not hidden, the last verdict, the error of left-out conditions
over what noise alone gives, and the tactical diameter beside that of the ship in the tank.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import os
import shlex
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import pmmkit as pk
from pmmkit.campaigns import save_campaign
from pmmkit.cli import main as typed
from pmmkit.models import Model, load_model
from pmmkit.workbench.saved import find_result
from pmmkit.workbench.tasks import Tasks, Work
from scripts.studies.hidden_effects import ABSORBED, tank
from scripts.studies.workers import add_workers, crew, in_order

COUPLING = "yaw_sway_coupling"
SURGE = "surge_yaw_coupling"
"""The ship has it, and so has `cubic`: with it the ship in the tank is Son and Nomoto's."""
SHIP = "s175-3dof"
FN = 0.2
MOST = 6
"""Diagnoses after which a loop that has not ended is left."""


@dataclass(frozen=True, kw_only=True)
class End:
    """Where one way ended."""

    fault: str
    seed: int
    way: str
    steps: tuple[str, ...]
    verdict: str
    over_noise: float
    diameter: float

    @property
    def false(self) -> tuple[str, ...]:
        """Steps that are not hidden."""
        return tuple(name for name in self.steps if name not in (COUPLING, self.fault))


def faults() -> list[str]:
    """Faults that the base does not absorb."""
    return [x for x in tank().INSIDE if x.startswith("fault_") and x not in ABSORBED]


def ends(number: int, ways: Sequence[str], programme: str) -> list[End]:
    """One campaign, by each way."""
    fault = faults()[number % len(faults())]
    hidden = {COUPLING: 1.0, SURGE: 1.0, fault: 1.0}
    campaign = tank().hidden_campaign(programme, hidden, seed=number)
    found = []
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        save_campaign(campaign, "tests.h5")
        told("reduce tests.h5 --structure cubic --fn pooled --out reduced --parts", SHIP)
        for way in ways:
            steps, verdict, model = WAYS[way](campaign)
            fall = model_of_steps(campaign, steps).fall()
            found.append(
                End(
                    fault=fault,
                    seed=number,
                    way=way,
                    steps=steps,
                    verdict=verdict,
                    over_noise=fall.totals[-1] / fall.levels(fall.of)[-1],
                    diameter=diameter(model),
                )
            )
    return found


def told(line: str, *more: str) -> str:
    """What a command prints."""
    output = io.StringIO()
    with contextlib.redirect_stdout(output), contextlib.redirect_stderr(io.StringIO()):
        status = typed([*shlex.split(line), *more])
    if status:
        raise RuntimeError(f"{line}: {status}\n{output.getvalue()}")
    return output.getvalue()


def added(said: str) -> str | None:
    """Type what the line ``Next:`` of a diagnosis adds; the model that it makes, if any."""
    following = [x for x in said.splitlines() if x.startswith("Next: pmmkit add ")]
    if not following:
        return None
    line = following[0].removeprefix("Next: pmmkit ")
    told(line)
    return shlex.split(line)[-1]


def diagnosis_in(folder: str) -> dict[str, Any]:
    """A diagnosis that was written."""
    found: dict[str, Any] = json.loads(Path(folder, "diagnosis.json").read_text(encoding="utf-8"))
    return found


def by_command(_: pk.Campaign) -> tuple[tuple[str, ...], str, Model]:
    """Type what each answer says comes next."""
    model, steps, number = "reduced/model.toml", [], 0
    for number in range(MOST):
        better = added(told(f"diagnose {model} tests.h5 --no-figures --out diagnosed{number}"))
        if better is None:
            break
        model = better
        steps = [step.effect for step in load_model(model).steps if step.effect]
    return tuple(steps), diagnosis_in(f"diagnosed{number}")["verdict"], load_model(model)


def by_session(campaign: pk.Campaign) -> tuple[tuple[str, ...], str, Model]:
    """Add what is proposed, in Python."""
    session = pk.begin("reduced/model.toml", campaign)
    for _ in range(MOST):
        found = session.diagnose()
        if not found.proposed:
            break
        for item in found.proposed:
            session = session.add(item)
    return tuple(step.effect for step in session.steps), found.verdict, session.model()


def by_given(campaign: pk.Campaign) -> tuple[tuple[str, ...], str, Model]:
    """Ask with all effects so far as given."""
    steps: list[str] = []
    for number in range(MOST):
        given = " ".join(f"--given {name}" for name in steps)
        folder = f"given{number}"
        told(f"diagnose reduced/model.toml tests.h5 --no-figures --out {folder} {given}")
        content = diagnosis_in(folder)
        if not content["proposed"]:
            break
        steps += content["proposed"]
    model = model_of_steps(campaign, steps).model()
    return tuple(steps), content["verdict"], model


def by_page(campaign: pk.Campaign) -> tuple[tuple[str, ...], str, Model]:
    """Press *Add* on the candidate that stands first, as long as one is named."""
    tasks = Tasks()
    work = Work(folder=Path("page").resolve(), campaigns=(str(Path("tests.h5").resolve()),))
    os.makedirs(work.folder)
    quiet = lambda *_: None  # noqa: E731
    tasks.open(work, str(Path("reduced/model.toml").resolve()), None, tell=quiet)
    for _ in range(MOST):
        tasks.diagnose(work, tell=quiet)
        page = find_result(work.folder, "missing", work.effects)
        named = [x["effect"] for x in page["candidates"] if x["named"]]
        if not named:
            break
        tasks.add(work, named[0], "", "", None, tell=quiet)
        work = replace(work, effects=(*work.effects, named[0]))
    return work.effects, page["verdict"], model_of_steps(campaign, work.effects).model()


WAYS: dict[str, Callable[[pk.Campaign], tuple[tuple[str, ...], str, Model]]] = {
    "command": by_command,
    "session": by_session,
    "given": by_given,
    "page": by_page,
}


def model_of_steps(campaign: pk.Campaign, steps: Sequence[str]) -> pk.Session:
    """A session with some steps."""
    session = pk.begin("reduced/model.toml", campaign)
    for name in steps:
        session = session.add(name)
    return session


def diameter(model: Model) -> float:
    """Tactical diameter at full rudder [L]."""
    speed = model.ship.speed(FN, model.water.g)
    track = pk.simulate(model, "turning", rudder_deg=35.0, speed=speed)
    return float(track.metrics["tactical_diameter_L"])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--loops", type=int, default=20)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--ways", nargs="*", choices=list(WAYS), default=list(WAYS))
    parser.add_argument("--programme", default="full")
    add_workers(parser, usual=2)
    o = parser.parse_args()
    work = partial(ends, ways=o.ways, programme=o.programme)
    with crew(o) as executor:
        every = [
            x for own in in_order(work, range(o.first, o.first + o.loops), executor) for x in own
        ]
    truth = diameter(load_model(SHIP))
    print(f"{'seed':>4} {'way':8} {'verdict':15} {'/noise':>6} {'TD':>6}  steps")
    for x in every:
        steps = ", ".join(f"!{name}" if name in x.false else name for name in x.steps)
        print(f"{x.seed:4} {x.way:8} {x.verdict:15} {x.over_noise:6.3f} {x.diameter:6.3f}  {steps}")
    print(f"The ship in the tank: {truth:.3f}")
    for way in o.ways:
        own = [x for x in every if x.way == way]
        apart = [abs(x.diameter / truth - 1) for x in own]
        print(
            f"{way}: {sum(x.verdict == 'noise' for x in own)} of {len(own)} end in noise, "
            f"{sum(len(x.false) for x in own)} false steps, "
            f"diameter within {100 * max(apart):.2f} %"
        )


if __name__ == "__main__":
    main()
