"""Kinds of test: the contract over all of them, and one of another package through everything."""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import small_campaign

import pmmkit as pk
from pmmkit import Campaign, Run, next_runs, reduce_campaign
from pmmkit.base import CampaignError, UnknownNameError
from pmmkit.campaigns import TEST_KINDS, Settings, TestKind
from pmmkit.campaigns.test_kinds.kind import SURGE, NominalMotion
from pmmkit.campaigns.test_kinds.oscillating import PURE_SWAY, PURE_YAW, SWAY_YAW
from pmmkit.campaigns.test_kinds.steady import STATIC_DRIFT, STRAIGHT
from pmmkit.conventions import Ship, Water
from pmmkit.diagnosis import Limits, read_plan_file
from pmmkit.diagnosis.planning.options import options_of
from pmmkit.intake.blocks import held_too, kind_with
from pmmkit.intake.drafts.names import asked_of, facts_of
from pmmkit.simulation import MANOEUVRES
from pmmkit.testing.test_kinds import check_test_kind

SUPPORT = Path(__file__).parents[1] / "support"


@pytest.mark.parametrize("name", TEST_KINDS.own)
def test_every_kind_holds_the_contract(name: str) -> None:
    check_test_kind(TEST_KINDS[name])


def wrong_sway(settings, theta):
    """Sway whose acceleration has the wrong sign."""
    tank = PURE_SWAY.motion.tank(settings, theta)
    return replace(tank, yddot=-tank.yddot)


def without_units(settings, theta):
    """Sway in which somebody forgot the carriage."""
    tank = PURE_SWAY.motion.tank(settings, theta)
    return replace(tank, xdot=np.ones_like(theta))


def cosine(settings, theta):
    """Sway that begins at its largest displacement."""
    return PURE_SWAY.motion.tank(settings, theta + math.pi / 2)


def growing(settings, theta):
    """Sway that grows from cycle to cycle."""
    tank = PURE_SWAY.motion.tank(settings, theta)
    return replace(tank, ydot=tank.ydot * (1 + theta))


@pytest.mark.parametrize(
    ("kind", "message"),
    [
        (replace(PURE_SWAY, name="Pure Sway"), "small letters"),
        (replace(PURE_SWAY, title="pure_sway"), "not one for people"),
        (replace(PURE_SWAY, codes=("PY",)), "'PY' is one of pure_yaw"),
        (replace(PURE_SWAY, phrase=r"\byaw\b"), "does not find its title"),
        (replace(PURE_SWAY, phrase="("), "no regular expression"),
        (replace(PURE_SWAY, name="pure_yaw"), "another kind of test has its name"),
        (replace(PURE_SWAY, needs=("period",)), "needs amplitude, and does not say so"),
        (replace(PURE_SWAY, needs=("period", "amplitude", "breadth")), "breadth is no setting"),
        (replace(PURE_SWAY, takes=("amplitude",)), "a setting comes twice"),
        (replace(PURE_SWAY, takes=("phase",)), "phase goes without saying"),
        (replace(PURE_SWAY, varies=("v", "vdot", "w")), "w is no variable"),
        (replace(PURE_SWAY, varies=("v",)), "vdot should be zero"),
        (replace(PURE_SWAY, varies=("v", "vdot", "r")), "r should vary and does not"),
        (replace(PURE_SWAY, varies=("v", "vdot", "phi")), "heel is none of its settings"),
        (replace(PURE_SWAY, swings=()), "nothing swings in it"),
        (replace(PURE_SWAY, swings=(SURGE,)), "u does not go with cos θ"),
        (replace(PURE_SWAY, family="steady"), "is not of the oscillating family"),
        (replace(PURE_SWAY, family="moored"), "its family is 'moored'"),
        (replace(PURE_SWAY, family="free-running"), "is free running, and has a motion"),
        (replace(PURE_SWAY, motion=NominalMotion()), "no nominal motion"),
        (replace(PURE_SWAY, motion=STRAIGHT), "v should vary and does not"),
        (replace(PURE_SWAY, motion=NominalMotion(tank=wrong_sway)), "vdot is not the rate"),
        (replace(PURE_SWAY, motion=NominalMotion(tank=without_units)), "u has not the unit"),
        (replace(PURE_SWAY, motion=NominalMotion(tank=cosine)), "v does not go with cos θ"),
        (replace(PURE_SWAY, motion=NominalMotion(tank=growing)), "come back after a period"),
        (
            replace(PURE_SWAY, motion=replace(PURE_YAW.motion, tank=PURE_SWAY.motion.tank)),
            "in tank axes and in ship axes are not one",
        ),
        (
            replace(PURE_SWAY, motion=replace(PURE_SWAY.motion, place=STRAIGHT.place)),
            "not where its velocities take it",
        ),
        (replace(SWAY_YAW, told_by=SWAY_YAW.told_by[:1]), None),
        (
            replace(SWAY_YAW, told_by=(replace(SWAY_YAW.told_by[1], with_cosine=True),)),
            "r does not go with cos θ",
        ),
        (replace(STATIC_DRIFT, needs=("drift", "period")), "settings of an oscillation"),
        (replace(STATIC_DRIFT, needs=(), shares=None), "v should vary and does not"),
        (replace(STATIC_DRIFT, shares={"heel": (0.5,)}), "its shares are of heel"),
        (replace(STATIC_DRIFT, shares={}), "its shares leave out drift"),
        (replace(STATIC_DRIFT, quasi_steady=0.0), "is not positive"),
    ],
)
def test_wrong_kinds_are_caught(kind: TestKind, message: str | None) -> None:
    if message is None:
        check_test_kind(kind)
        return
    with pytest.raises(AssertionError) as caught:
        check_test_kind(kind)
    assert message in str(caught.value)


def test_a_name_that_is_not_known_is_answered_with_the_nearest() -> None:
    with pytest.raises(UnknownNameError, match="did you mean 'zigzag'"):
        TEST_KINDS["zigzak"]


def test_kinds_are_found_by_what_moves_and_what_is_held() -> None:
    for kind in TEST_KINDS.own.values():
        if kind.captive and not kind.straight_ahead:
            swings = {swing.velocity for swing in kind.swings}
            held = [name for name in kind.held if name != "yaw_rate"]
            assert kind_with(swings=swings, held=held, turning=kind.circles) is kind
    assert kind_with(held={"heel", "switch"}) is None
    assert held_too(PURE_YAW, "drift").drifts


def test_what_is_zero_is_all_that_does_not_vary() -> None:
    for kind in TEST_KINDS.own.values():
        wanted = set(TestKind.MAY_BE_ZERO) - set(kind.varies) if kind.captive else set()
        assert set(kind.zero) == wanted


def test_manoeuvres_that_are_sailed_have_the_names_of_those_that_are_simulated() -> None:
    sailed = {name for name, kind in TEST_KINDS.own.items() if kind.free_running}
    assert sailed - {"random"} <= set(MANOEUVRES)


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """A package with a kind of test of its own, found by its entry point."""
    package = tmp_path / "site"
    info = package / "our_tank-1.0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: our-tank\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[pmmkit.test_kinds]\nown = our_tank:KIND\n")
    (package / "our_tank.py").write_text((SUPPORT / "double_sway.py").read_text("utf-8"), "utf-8")
    monkeypatch.syspath_prepend(str(package))
    TEST_KINDS.reload()
    yield TEST_KINDS["double_sway"]
    TEST_KINDS.reload()
    sys.modules.pop("our_tank", None)


@pytest.fixture
def folder(tmp_path, installed):
    """The small campaign with four runs of that kind, without any column of motion."""
    made = small_campaign.write_campaign(tmp_path / "campaign", noise=0.3)
    text = [(made / "campaign.toml").read_text(encoding="utf-8")]
    generator = np.random.default_rng(3)
    for speed in small_campaign.SPEEDS:
        period = 12.5 / speed
        for degrees in (-6.0, 6.0):
            settings = Settings(
                speed=speed, drift=math.radians(degrees), period=period, amplitude=0.2
            )
            name = f"DS_U{speed:g}_b{degrees:+g}"
            run = Run(
                id=name, test=installed.name, kind="history", settings=settings, loader=lambda: None
            )
            t = np.arange(0.0, 4 * period - 1e-9, period / 250)
            state = run.nominal_motion(t)
            motion = {key: getattr(state, key) for key in ("u", "v", "r", "udot", "vdot", "rdot")}
            force = small_campaign.forces(**motion)
            columns = [
                force[key] + 0.3 * small_campaign.NOISE[key] * generator.normal(size=len(t))
                for key in "XYN"
            ]
            np.savetxt(
                made / "runs" / f"{name}.csv",
                np.stack([t, *columns], axis=1),
                delimiter=",",
                header="t,X,Y,N",
                comments="",
            )
            text.append(
                f'\n[[runs]]\nid = "{name}"\ntest = "double_sway"\nfile = "runs/{name}.csv"\n'
                f"speed = {speed}\nperiod = {period}\namplitude_m = 0.2\ndrift_deg = {degrees}\n"
            )
    (made / "campaign.toml").write_text("".join(text), encoding="utf-8")
    return made


def test_a_kind_of_another_package_holds_the_contract(installed) -> None:
    assert list(TEST_KINDS)[-1] == "double_sway"
    check_test_kind(installed)


@pytest.mark.slow
def test_a_kind_of_another_package_is_reduced_compared_and_planned(folder, installed) -> None:
    campaign = pk.open_campaign(folder)
    found = reduce_campaign(campaign, executor=1)
    assert not [item for item in found.findings if item.severity == "error"]
    own = found.families["double sway"].at(2.0 / math.sqrt(9.81 * small_campaign.L))
    assert own["Yv"] == pytest.approx(small_campaign.TRUTH["Yv"], rel=0.05)
    assert own["Yvdot"] == pytest.approx(small_campaign.TRUTH["Yvdot"], rel=0.05)
    model = pk.to_model(found.table, parts="s175")
    compared = pk.compare(model, campaign)
    errors = [row for row in compared.rows() if row["test"] == "double_sway"]
    assert {row["run"] for row in errors} == {x.id for x in campaign if x.test == "double_sway"}
    assert all(row["relative"] < 0.1 for row in errors if row["channel"] != "X")
    limits = Limits.of(campaign).with_(tests=("double_sway",), speeds=(1.5,), frequencies=(1.5,))
    options = options_of(limits, campaign.ship, campaign.water)
    assert len(options) == 4
    assert all(option.id.startswith("DS_1.5_b") for option in options)
    advice = next_runs(
        model, campaign, effects=("modulus_sway_drag", "nonlinear_added_mass"), options=options
    )
    assert advice.runs[0].option.test == "double_sway", advice.words


def test_a_kind_of_another_package_is_drafted_and_listed_in_plans(installed, tmp_path) -> None:
    named = facts_of("DS_U1.5_T12.5_a0.2_b+06")
    assert named.test == "double_sway"
    assert {"period", "amplitude_m", "drift_deg"} <= set(named.settings)
    assert asked_of("double_sway") == ("period", "amplitude_m", "drift_deg")
    plan = tmp_path / "plan.toml"
    plan.write_text(
        '[[runs]]\ntest = "double_sway"\nspeed = 1.5\nperiod = 10.0\namplitude_m = 0.3\n'
        "drift_deg = 4.0\n",
        encoding="utf-8",
    )
    _, listed = read_plan_file(plan, pk.load_ship("s175"))
    assert [option.words for option in listed] == [
        "double sway at 1.5 m/s, period 10 s, amplitude 0.3 m, drift +4°"
    ]


def test_what_its_runs_lack_is_named(folder, installed) -> None:
    text = (folder / "campaign.toml").read_text(encoding="utf-8")
    (folder / "campaign.toml").write_text(text.replace("amplitude_m = 0.2\n", ""), "utf-8")
    with pytest.raises(CampaignError, match="amplitude_m"):
        pk.open_campaign(folder)
    (folder / "campaign.toml").write_text(text.replace('"double_sway"', '"duoble_sway"'), "utf-8")
    with pytest.raises(CampaignError, match="did you mean 'double_sway'"):
        pk.open_campaign(folder)


def test_a_mistyped_kind_selects_nothing_and_is_told():
    ship = Ship(name="m", L=4.0, B=1.0, d=0.25, volume=0.5, mass=500.0, Izz=500.0)
    empty = Campaign(title="", ship=ship, water=Water(), runs=())
    assert empty.select("static_drift", "turning").runs == ()
    with pytest.raises(UnknownNameError, match="did you mean 'static_drift'"):
        empty.select("static_drfit")
