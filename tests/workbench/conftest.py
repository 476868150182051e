"""A workbench whose whole loop was gone through, for the tests that look at it afterwards."""

from __future__ import annotations

import pytest
from asgi import Browser
from hidden_effects import hidden_campaign
from long_work import done

from pmmkit import save_campaign, without_effect
from pmmkit.actions import action
from pmmkit.models import load_model, save_model
from pmmkit.workbench import Desk
from pmmkit.workbench.application import application


@pytest.fixture(scope="session")
def place(tmp_path_factory):
    """A middle programme with two effects hidden, its name full of markup, and a model."""
    folder = tmp_path_factory.mktemp("tests")
    hidden = {"yaw_sway_coupling": 1.0, "fault_misalignment": 1.0}
    campaign = hidden_campaign("middle", hidden, seed=3).with_(title="</script><b>hidden</b>")
    save_campaign(campaign, folder / "hidden.h5")
    save_model(without_effect(load_model("s175-3dof"), "yaw_sway_coupling"), folder / "model.toml")
    return folder


@pytest.fixture(scope="session")
def looped_desk(place):
    own = Desk(place / "workbench", [place], action)
    yield own
    own.close()


@pytest.fixture(scope="session")
def looped_browser(looped_desk):
    return Browser(application(looped_desk, "key", 8175), 8175, "key")


@pytest.fixture(scope="session")
def looped(place, looped_browser):
    """Open, ask, add what is named: the answers on the way."""
    browser = looped_browser
    opened = done(
        browser, "open", campaign=str(place / "hidden.h5"), model=str(place / "model.toml")
    )
    before = browser.get("/api/misfit").json
    done(browser, "diagnose")
    missing = browser.get("/api/missing").json
    named = [item["effect"] for item in missing["candidates"] if item["named"]]
    for effect in named:
        state = done(browser, "add", effect=effect)
    fall = browser.get("/api/fall").json
    after = browser.get("/api/misfit").json
    return {
        "opened": opened,
        "before": before,
        "named": named,
        "state": state,
        "fall": fall,
        "after": after,
    }
