"""The ships of the library in every manoeuvre, and the page of the workbench."""

from __future__ import annotations

import json
from functools import partial
from typing import Any

from scripts.golden.job import SPEEDS, Job, empty_folder, masked


def sailed(ship: str) -> dict[str, Any]:
    """A ship in every manoeuvre, with the settings that are usual."""
    import pmmkit as pk
    from pmmkit.simulation import MANOEUVRES

    found: dict[str, Any] = {}
    for name in sorted(MANOEUVRES):
        try:
            track = pk.simulate(pk.load_model(ship), name, speed=SPEEDS[ship])
        except pk.PmmkitError as error:
            found[name] = str(error)
            continue
        data = track.to_xarray()
        found[name] = {
            "metrics": dict(track.metrics),
            "track": {str(key): data[key].values for key in data.data_vars},
            "told": str(track).splitlines(),
        }
    return found


def many() -> dict[str, Any]:
    """Drawn ships, by their metrics."""
    import pmmkit as pk

    found = pk.monte_carlo(
        pk.load_model("kvlcc2"), "turning", rudder_deg=35, speed=7.97, n=64, spread=0.05, seed=1
    )
    return {"told": str(found).splitlines()}


def page() -> dict[str, Any]:
    """What the page of a workbench is told: open, ask, add what is named first."""
    import pmmkit as pk
    from pmmkit.actions import action
    from pmmkit.workbench import Desk, WorkbenchState
    from pmmkit.workbench.application import answers
    from scripts.studies.hidden_effects import tank

    with empty_folder() as folder:
        hidden = {"yaw_sway_coupling": 1.0, "fault_misalignment": 1.0}
        pk.save_campaign(tank().hidden_campaign("middle", hidden, seed=3), folder / "tests.h5")
        bare = pk.without_effect(pk.load_model("s175-3dof"), "yaw_sway_coupling")
        pk.save_model(bare, folder / "model.toml")
        desk = Desk(folder / "workbench", [folder], action)
        try:
            desk.open(
                WorkbenchState(campaign=str(folder / "tests.h5"), model=str(folder / "model.toml"))
            )
            desk.wait(lambda _: None)
            desk.diagnose(desk.page()["revision"])
            desk.wait(lambda _: None)
            named = [x["effect"] for x in desk.missing()["candidates"] if x["named"]]
            desk.add(desk.page()["revision"], named[0])
            desk.wait(lambda _: None)
            told = json.dumps(answers(desk), default=str)
        finally:
            desk.close()
        found: dict[str, Any] = json.loads(masked(told, folder))
    del found["state"]["job"]  # what it is at, by the clock
    for page in found["turns"].values():
        page.pop("band", None)  # draws along eigenvectors, whose signs a processor chooses
    return found


JOBS = (
    *(Job(f"sailed_{ship}", partial(sailed, ship)) for ship in SPEEDS),
    Job("many_ships", many),
    Job("page_captive", page, tolerance=1e-6),
)
