"""A setting is said once: option, help, pages and forms follow from its field."""

from __future__ import annotations

import shlex
from dataclasses import MISSING, field, make_dataclass, replace
from pathlib import Path
from typing import Annotated, Literal

import pytest
import typer
from asgi import Browser

from pmmkit.actions import Outcome, SettingError, action, names
from pmmkit.actions.jobs.compare import CompareSettings
from pmmkit.actions.setting import Help, as_typed, settings_from, settings_of, stated
from pmmkit.actions.shared import OrderSettings
from pmmkit.cli import app, main
from pmmkit.workbench import Desk
from pmmkit.workbench.application import application
from scripts.documentation.actions import shared_table
from scripts.documentation.site.reference import command_page

MOST = 12
"""Settings of a job that stand without a group."""
ADDED = Annotated[Literal["thick", "thin"], Help("How thick the ice is.", names="--ice", unit="-")]


@pytest.fixture
def icy(monkeypatch):
    """`compare` with one setting more, which says what it got."""

    def do(job):
        return Outcome(content={"ice": job.frozen}, lines=[job.frozen])

    settings = make_dataclass(
        "IcySettings",
        [("frozen", ADDED, field(default="thin"))],
        bases=(CompareSettings,),
        frozen=True,
        kw_only=True,
    )
    own = replace(action("compare"), settings=settings, do=do)
    monkeypatch.setattr(app, "action", lambda _: own)
    return own


def test_an_option_added_to_a_dataclass_is_there_everywhere(icy, capsys, tmp_path):
    assert main(["compare", "--help"]) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert "--ice" in told
    assert "How thick the ice is. [default: thin]" in told
    command = typer.main.get_command(app.application("compare")).commands["compare"]
    assert "How thick the ice is" in command_page("compare", command)
    assert "--ice` thick or thin (thin if absent) | How thick the ice is" in shared_table([icy] * 3)
    page = Browser(application(Desk(tmp_path, [tmp_path], lambda _: icy), "key", 8175), 8175, "key")
    answer = page.get("/api/settings?of=compare").json
    (shown,) = (item for item in answer if item["name"] == "frozen")
    assert shown == {
        "name": "frozen",
        "option": "--ice",
        "help": "How thick the ice is.",
        "heading": "",
        "type": "choice",
        "choices": ["thick", "thin"],
        "several": False,
        "required": False,
        "default": "thin",
        "least": None,
        "most": None,
        "usual": None,
        "unit": "-",
    }
    assert main(["compare", "kvlcc2", "mine", "--ice", "thick"]) == 0
    assert capsys.readouterr().out == "thick\n"
    assert main(["compare", "kvlcc2", "mine"]) == 0
    assert capsys.readouterr().out == "thin\n"
    assert main(["compare", "kvlcc2", "mine", "--ice", "grey"]) == 2


@pytest.mark.parametrize("name", names())
def test_the_settings_of_an_action_are_few_or_in_groups(name):
    own = action(name)
    assert own.example.startswith(f"pmmkit {name}")
    assert len({item.name for item in own.fields}) == len(own.fields)
    assert sum(not item.group for item in own.fields) <= MOST
    for item in own.fields:
        assert item.help.text
        assert bool(item.group) == bool(item.heading)
    arguments = [item for item in own.fields if item.help.argument]
    assert [item.required for item in arguments] == sorted(
        (item.required for item in arguments), reverse=True
    )


@pytest.mark.parametrize("name", names())
def test_settings_are_typed_as_the_command_reads_them(name, monkeypatch, capsys):
    """Each value that is not the one if absent stands on the line, and comes back from it."""
    own, heard = action(name), []
    monkeypatch.setattr(
        app,
        "action",
        lambda _: replace(own, do=lambda job: heard.append(job) or Outcome(content={}, lines=[])),
    )
    job = own.asked({item.name: example_of(item) for item in own.fields})
    assert len(stated(job)) == sum(item.choices != (item.default,) for item in own.fields)
    assert main([name, *shlex.split(as_typed(job))]) == 0, capsys.readouterr().err
    assert heard == [job]


def example_of(item):
    """A value that is not the default."""
    if item.choices:
        return item.choices[-1] if item.default == item.choices[0] else item.choices[0]
    if item.bare is bool:
        return not item.default
    if item.help.read is not None:
        value = item.help.read("7.5 m/s")
    elif item.bare is Path:
        value = Path("some where")
    elif item.bare is str:
        value = "it's"
    else:
        low = -3 if item.help.least is None else item.help.least
        high = low + 8 if item.help.most is None else item.help.most
        value = item.bare(low + (high - low) / 4 if item.bare is float else low + 5)
    return (value, value) if item.several else value


@pytest.mark.parametrize(
    ("wrong", "value"),
    [("wind_speed", "fast"), ("depth", True), ("figures", False), ("seed", 3), ("more", ["dt=1"])],
)
def test_a_form_may_sail_with_orders_and_conditions_alone(wrong, value, tmp_path):
    page = Browser(application(Desk(tmp_path, [tmp_path], action), "key", 8175), 8175, "key")
    asked = {"manoeuvre": "turning", "speed": 8.0, "rudder_deg": 20.0, "band": True}
    assert "Nothing is open yet" in page.post("/api/sail", asked).json["error"]
    told = page.post("/api/sail", asked | {wrong: value}).json["error"]
    assert told == f"{wrong} is no setting of a manoeuvre, or has no such value."
    assert page.get("/api/settings?of=nothing").status == 400


def test_settings_are_reached_by_name_whatever_their_group():
    job = settings_from(
        CompareSettings, {"model": "a", "campaigns": (Path("b"),), "wave_height": 2.0}
    )
    assert job.waves.wave_height == 2.0
    assert stated(job) == {"model": "a", "campaigns": (Path("b"),), "wave_height": 2.0}
    assert settings_of(CompareSettings)[0].default is MISSING


def test_half_a_sea_is_refused_in_python_and_on_the_console(capsys):
    waves = settings_from(
        CompareSettings, {"model": "a", "campaigns": (Path("b"),), "wave_height": 2.0}
    ).waves
    with pytest.raises(SettingError, match="--wave-period"):
        _ = waves.sea
    assert main(["simulate", "kvlcc2", "--speed", "8", "--wave-height", "3"]) == 2
    assert "Waves need a height and a peak period" in capsys.readouterr().err


def test_any_setting_of_a_manoeuvre_stands_beside_the_usual_ones():
    orders = OrderSettings(rudder_deg=20.0, more=("executes=7", "rudder-deg=25"))
    assert orders.given() == {"rudder_deg": 25.0, "executes": 7.0}
    assert OrderSettings().given() == {}
