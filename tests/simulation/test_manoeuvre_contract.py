"""Every manoeuvre and every metric holds its contract; new ones work everywhere, wrong ones do not
pass."""

from __future__ import annotations

import itertools
import json
import math
from dataclasses import replace
from importlib.metadata import EntryPoint, EntryPoints

import numpy as np
import pytest

from pmmkit.base import DataError, UnknownNameError
from pmmkit.conventions import METRICS, Criterion, Metric
from pmmkit.equations import Ask, End, Phase, Plan, Probe
from pmmkit.simulation import (
    MANOEUVRES,
    Manoeuvre,
    Setting,
    monte_carlo,
    sensitivities,
    simulate,
    sweep,
)
from pmmkit.simulation.kinds.manoeuvre import rudder_setting
from pmmkit.testing.manoeuvres import check_manoeuvre, check_metric

SMALLER = {"spiral": {"rudder_deg": 10.0, "step_deg": 5.0}}
"""Settings that take less time."""


@pytest.mark.slow
@pytest.mark.parametrize("name", MANOEUVRES)
def test_every_manoeuvre_holds_its_contract(name):
    check_manoeuvre(MANOEUVRES[name], **SMALLER.get(name, {}))


@pytest.mark.parametrize("metric", METRICS.values(), ids=lambda metric: metric.name)
def test_every_metric_holds_its_contract(metric):
    check_metric(metric)


def test_no_number_has_two_meanings():
    names = [metric.name for metric in METRICS.values()]
    assert len(set(names)) == len(names)
    for metric in METRICS.values():
        assert Metric.of(metric.name.format(2)) is metric
    ours = {metric.name for item in MANOEUVRES.values() for metric in item.metrics}
    assert set(names) - ours == {"speed_loss"}  # trials alone measure it


def test_each_criterion_is_named_once():
    names = [criterion.name for _, criterion in METRICS.criteria]
    assert len(set(names)) == len(names) == 7


@pytest.mark.parametrize(
    ("wrong", "meant"), [("zig-zag", "zigzag"), ("Turning", "turning"), ("wiliamson", "williamson")]
)
def test_the_manoeuvre_that_was_meant_is_named(wrong, meant):
    with pytest.raises(UnknownNameError, match=f"did you mean '{meant}'"):
        simulate("s175-3dof", wrong, speed=8.0)


def test_a_manoeuvre_that_is_near_to_none_is_told_in_two_sentences():
    with pytest.raises(UnknownNameError, match=r"There is no manoeuvre 'zzz'\. There are: "):
        simulate("s175-3dof", "zzz", speed=8.0)


def test_the_metric_that_was_meant_is_named():
    with pytest.raises(UnknownNameError, match="did you mean 'tactical_diameter'"):
        Metric.of("tactical_diametre").unit_of("tactical_diametre")
    with pytest.raises(UnknownNameError):
        Metric.of("time_90_L").unit_of("time_90_L")


def test_a_sweep_over_a_whole_number_is_one():
    found = sweep("s175-3dof", "executes", [3, 4], manoeuvre="zigzag", speed=8.0, compiled=False)
    assert found["executes"].attrs["units"] == "-"
    assert np.isfinite(found["overshoot_2_deg"]).all()


# A new one


def easing(pace, *, rudder_deg, ease_deg):
    """Turn to a heading, then amidships: how far the ship still turns."""
    rudder = math.radians(rudder_deg)
    side = math.copysign(1.0, rudder)
    phases = (
        Phase(
            rudder=rudder,
            until=End.heading,
            level=side * math.radians(ease_deg),
            side=side,
            longest=500.0 / pace,
        ),
        Phase(rudder=0.0, longest=10.0 / pace),
    )
    probes = {
        "ease": Probe(ask=Ask.begin, first=1, last=1),
        "end": Probe(ask=Ask.end, first=1, last=1),
    }

    def measure(found):
        return {
            "time_ease": found.t("ease"),
            "way_eased": found.at("end", "x") - found.at("ease", "x"),
            "turned_eased_deg": side * np.degrees(found.at("end", "psi") - found.at("ease", "psi")),
        }

    return Plan(phases=phases, probes=probes, measure=measure, rudder=rudder)


EASING = Manoeuvre(
    name="easing",
    title="easing the rudder",
    settings=(
        rudder_setting(20.0),
        Setting(name="ease_deg", text="heading before easing", unit="deg", required=True),
    ),
    orders=easing,
    metrics=(
        *METRICS.named("time_ease"),
        Metric(name="way_eased", symbol="x", title="way with the rudder amidships", unit="m"),
        Metric(name="turned_eased_deg", symbol="ψ", title="turned meanwhile", unit="deg"),
    ),
)


@pytest.mark.slow
def test_a_new_manoeuvre_works_like_those_of_pmmkit():
    check_manoeuvre(EASING, ease_deg=30.0)
    track = simulate("s175-3dof", EASING, speed=8.0, ease_deg=30.0)
    assert track.manoeuvre == "easing"
    assert track.metrics["way_eased_L"] == pytest.approx(track.metrics["way_eased"] / 175.0)
    assert set(track.figures()) == {"path", "histories"}
    swept = sweep("s175-3dof", "ease_deg", [20.0, 40.0], EASING, speed=8.0)
    assert swept.attrs["manoeuvre"] == "easing"
    assert swept["ease_deg"].attrs["units"] == swept["turned_eased_deg"].attrs["units"] == "deg"
    assert swept["way_eased"].attrs["units"] == "m"
    many = monte_carlo("s175-3dof", EASING, speed=8.0, ease_deg=30.0, n=20, spread=0.05)
    low, high = many.interval("turned_eased_deg")
    assert low < track.metrics["turned_eased_deg"] < high
    assert many.units["way_eased_L"] == "L"
    found = sensitivities("s175-3dof", EASING, speed=8.0, ease_deg=30.0, spread=0.05)
    assert np.isfinite(found.slopes["turned_eased_deg"]).all()


def test_what_a_manoeuvre_requires_must_be_given():
    with pytest.raises(DataError, match="easing needs ease_deg"):
        simulate("s175-3dof", EASING, speed=8.0)
    with pytest.raises(DataError, match="easing has no switch_deg"):
        simulate("s175-3dof", EASING, speed=8.0, ease_deg=10.0, switch_deg=3.0)


@pytest.fixture
def installed(monkeypatch):
    """Another package that brings the manoeuvre."""
    point = EntryPoint("easing", f"{__name__}:EASING", "pmmkit.manoeuvres")
    monkeypatch.setattr(
        "importlib.metadata.entry_points", lambda group: EntryPoints([point]).select(group=group)
    )
    MANOEUVRES.reload()
    yield
    MANOEUVRES.reload()


def test_an_installed_package_brings_a_manoeuvre(installed):
    assert [*MANOEUVRES][-1] == "easing"
    track = simulate("s175-3dof", "easing", speed=8.0, ease_deg=30.0, compiled=False)
    assert track.metrics["time_ease"] > 0.0


# Wrong ones


def changed(**how):
    return replace(EASING, **how)


def of_plan(change):
    """The manoeuvre with its plan changed."""

    def orders(pace, *, rudder_deg, ease_deg):
        return change(easing(pace, rudder_deg=rudder_deg, ease_deg=ease_deg))

    return changed(orders=orders)


def measuring(**more):
    """The manoeuvre with other numbers."""

    def change(plan):
        return replace(plan, measure=lambda found: plan.measure(found) | _called(more, found))

    return of_plan(change)


def _called(more, found):
    return {name: value(found) if callable(value) else value for name, value in more.items()}


def drifting():
    count = itertools.count()
    return of_plan(
        lambda plan: replace(
            plan, phases=(replace(plan.phases[0], shortest=float(next(count))), plan.phases[1])
        )
    )


def one_sided(pace, *, rudder_deg, ease_deg):
    plan = easing(pace, rudder_deg=rudder_deg, ease_deg=ease_deg)
    first, second = plan.phases
    return replace(plan, phases=(first, replace(second, rudder=0.05)))


def choosy(pace, *, rudder_deg, ease_deg):
    return easing(pace, rudder_deg=rudder_deg, ease_deg={30.0: 30.0}[ease_deg])


def silent(pace, *, rudder_deg, ease_deg):
    if ease_deg < 1.0:
        raise DataError("This cannot be done.")
    return easing(pace, rudder_deg=rudder_deg, ease_deg=ease_deg)


def other_from(run):
    """A number that is another from that run on: the third of a contract is the compiled one."""
    runs = itertools.count(1)
    return lambda found: 1.0 + (next(runs) >= run)


WRONG = {
    "small letters": changed(name="Easing it"),
    "declares no metric": changed(metrics=()),
    "takes rudder_deg, ease_deg; declared are rudder_deg": changed(settings=EASING.settings[:1]),
    "does not end with _deg": changed(
        settings=(EASING.settings[0], replace(EASING.settings[1], name="ease"))
    ),
    "the default of rudder_deg": changed(settings=(rudder_setting(120.0), EASING.settings[1])),
    "not the same twice": drifting(),
    "phases that there are not": of_plan(
        lambda plan: replace(plan, probes=plan.probes | {"later": Probe(ask=Ask.end, last=7)})
    ),
    "ease_deg = 1.0 ends in KeyError": changed(orders=choosy),
    "is refused without its name": changed(orders=silent),
    "does not consist of numbers": of_plan(
        lambda plan: replace(plan, phases=(replace(plan.phases[0], until="heading"),))
    ),
    "no metric 'speed_lost'": measuring(speed_lost=0.1),
    "does not give offset": changed(metrics=(*EASING.metrics, *METRICS.named("offset"))),
    "way_eased is nan": measuring(way_eased=math.nan),
    "to the other side turned_eased_deg": changed(orders=one_sided),
    "to the other side way_eased is": measuring(way_eased=lambda found: found.at("end", "y")),
    "when it is run again": measuring(way_eased=other_from(2)),
    "compiled way_eased": measuring(way_eased=other_from(3)),
}


@pytest.mark.parametrize("said", WRONG)
def test_a_wrong_manoeuvre_does_not_pass(said):
    with pytest.raises(AssertionError) as caught:
        check_manoeuvre(WRONG[said], ease_deg=30.0)
    assert said in str(caught.value)


LIMIT = Criterion(name="drift", paragraph="5.3.9", limit=3.0, manoeuvre="zigzag")
DRIFT = Metric(name="drift_deg", symbol="β", title="drift angle", unit="deg")


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"name": "Drift_deg"}, "small letters"),
        ({"name": "drift"}, "does not say its unit: _deg"),
        ({"unit": "rad"}, "its unit is 'rad'"),
        ({"symbol": ""}, "no symbol"),
        ({"name": "time_90_deg_L"}, "ends with _L"),
        ({"name": "speed_ratio", "unit": "m/s"}, "the metric of that name is in -"),
        ({"criteria": (LIMIT,)}, "judged by zigzag, which does not give it"),
        ({"criteria": (replace(LIMIT, limit=-1.0),)}, "the limit of drift is not positive"),
        ({"criteria": (replace(LIMIT, manoeuvre="jump"),)}, "'jump', which is no manoeuvre"),
        ({"criteria": (replace(LIMIT, settings={"step_deg": 1.0}),)}, "zigzag has no step_deg"),
        ({"criteria": (replace(LIMIT, paragraph=""),)}, "names no paragraph"),
    ],
)
def test_a_wrong_metric_does_not_pass(wrong, said):
    check_metric(DRIFT)
    with pytest.raises(AssertionError) as caught:
        check_metric(replace(DRIFT, **wrong))
    assert said in str(caught.value)


# The command line


def option(command, name):
    """An option of a command."""
    import typer.main

    from pmmkit.cli.app import application

    commands = typer.main.get_command(application()).commands
    return next(x for x in commands[command].params if x.name == name)


@pytest.mark.parametrize("command", ["simulate", "sweep", "uncertainty"])
def test_the_command_line_names_every_manoeuvre(command):
    said = option(command, "manoeuvre").help
    assert all(name in said for name in MANOEUVRES)


def test_any_setting_can_be_given_on_the_command_line(tmp_path, capsys):
    from pmmkit.cli import main

    given = ["simulate", "s175-3dof", "--speed", "8", "--no-figures", "--json"]
    given += ["--manoeuvre", "zigzag", "--set", "executes=3", "--out", str(tmp_path / "out")]
    assert main(given) == 0
    found = json.loads(capsys.readouterr().out)
    assert "overshoot_2_deg" in found
    assert "overshoot_3_deg" not in found
    assert main([*given, "--set", "executes"]) == 2
