"""The engine: accuracy, events, dense output, one ship and many, compiled and interpreted."""

from __future__ import annotations

import importlib
import math
import subprocess
import sys
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pmmkit import catalogue
from pmmkit.base import MissingPartError, ModelError, SimulationError
from pmmkit.effects import CATALOGUE
from pmmkit.equations import Gear, prepare, run, run_plan
from pmmkit.equations import prepare as prepare_kernel
from pmmkit.equations.compilation import is_compiled
from pmmkit.files import cache_folder
from pmmkit.identification import fit_to_forces
from pmmkit.identification.forces import ForceRecord
from pmmkit.models import Part, load_model, model_text, save_model, ships
from pmmkit.simulation import MANOEUVRES, Spread, monte_carlo, sensitivities, simulate, sobol
from pmmkit.simulation.ensemble import batch_of

TANKER = load_model("kvlcc2-l7")
SPEED = 1.179


def by_scipy(name, speed, rudder_deg, end, times):
    """States of a turn by another integrator (DOP853) on the same equations."""
    from scipy.integrate import solve_ivp

    ready = prepare_kernel(load_model(name), speed)
    n = ready.self_propulsion()
    model = load_model(name)
    rate = math.radians(model.values("rudder_mmg")["rate_deg_s"])
    order = math.radians(rudder_deg)
    start = [0.0] * len(ready.structure.states)
    start[3] = speed
    found, t0, y = [], 0.0, np.array(start)
    for stop in (order / rate, end):
        result = solve_ivp(
            lambda t, z: ready.rates(z, min(rate * t, order), n),
            (t0, stop),
            y,
            method="DOP853",
            rtol=1e-12,
            atol=1e-12,
            dense_output=True,
        )
        inside = times[(times >= t0) & (times < stop)] if stop < end else times[times >= t0]
        found.append(result.sol(inside))
        t0, y = stop, result.y[:, -1]
    return np.concatenate(found, axis=1)


@pytest.mark.parametrize(
    ("name", "speed"), [("kvlcc2-l7", SPEED), pytest.param("s175", 9.0, marks=pytest.mark.slow)]
)
def test_a_turn_is_that_of_another_integrator(name, speed):
    end = 60.0 * load_model(name).ship.L / speed / 2
    track = simulate(name, speed=speed, duration=end, rtol=1e-10)
    theirs = by_scipy(name, speed, 35.0, end, track.t)
    for row, channel in enumerate(("x", "y", "psi", "u", "v", "r")):
        span = np.ptp(theirs[row])
        assert np.max(np.abs(getattr(track, channel) - theirs[row])) < 3e-8 * span


def test_the_error_falls_with_the_tolerance():
    exact = simulate(TANKER, speed=SPEED, duration=60.0, rtol=1e-12)
    errors = [
        abs(simulate(TANKER, speed=SPEED, duration=60.0, rtol=rtol).x[-1] - exact.x[-1]) / 7.0
        for rtol in (1e-4, 1e-6, 1e-8)
    ]
    assert errors[0] > errors[1] > errors[2]
    assert errors[1] < 1e-5
    assert errors[2] < 1e-7


def test_a_phase_ends_where_its_event_is():
    ready = prepare(TANKER, SPEED)
    plan = MANOEUVRES["zigzag"].plan(SPEED / ready.L)
    history = run_plan(ready, plan, Gear(rudder_rate=0.2), rtol=1e-8, fast=False)
    switch = math.radians(10.0)
    for i, begin in enumerate(history.begins[1:], start=1):
        psi = history.sampled(np.array([begin]))[2, 0]
        assert psi == pytest.approx((-1.0) ** (i + 1) * switch, abs=1e-7)
    assert all(history.finished)


def test_the_dense_output_is_continuous():
    ready = prepare(TANKER, SPEED)
    history = run_plan(
        ready, MANOEUVRES["turning"].plan(SPEED / 7), Gear(rudder_rate=0.2), rtol=1e-6, fast=False
    )
    stride = ready.functions().STRIDE
    for step in range(1, history.kept):
        t = history.steps[stride * step]
        before, after = history.sampled(np.array([np.nextafter(t, 0), t])).T
        assert before == pytest.approx(after, abs=1e-9)


@pytest.mark.parametrize("name", ["s175", "kvlcc2-l7", "esso190k"])
@pytest.mark.parametrize("manoeuvre", ["turning", "zigzag"])
def test_interpreted_and_compiled_agree(name, manoeuvre):
    speed = load_model(name).ship.speed(0.142)
    one, other = (simulate(name, manoeuvre, speed=speed, compiled=x) for x in (True, False))
    np.testing.assert_array_equal(one.to_pandas(), other.to_pandas())
    for key, value in one.metrics.items():
        assert other.metrics[key] == pytest.approx(value, rel=0.0, nan_ok=True)


def test_a_structure_is_compiled_once_it_was_sailed_enough(monkeypatch):
    monkeypatch.setattr(run, "ENOUGH", 100)
    monkeypatch.setattr(run, "is_loaded", lambda _: False)
    monkeypatch.setattr(run, "_INTERPRETED", Counter())
    ready = prepare(TANKER, SPEED)
    plan = MANOEUVRES["turning"].plan(SPEED / 7)
    each = [run_plan(ready, plan, Gear(rudder_rate=0.2), rtol=1e-6) for _ in range(4)]
    fast = [history.fast for history in each]
    assert fast == sorted(fast)
    assert (fast[0], fast[-1]) == (False, True)
    stride = ready.functions().STRIDE
    assert len({tuple(history.steps[: stride * history.kept]) for history in each}) == 1


@pytest.mark.parametrize("there", [True, False])
def test_machine_code_on_the_disk_is_taken_after_a_few_turns(there, monkeypatch):
    monkeypatch.setattr(run, "FEW", 100)
    monkeypatch.setattr(run, "is_compiled", lambda _: there)
    monkeypatch.setattr(run, "is_loaded", lambda _: False)
    monkeypatch.setattr(run, "_INTERPRETED", Counter())
    ready, plan = prepare(TANKER, SPEED), MANOEUVRES["turning"].plan(SPEED / 7)
    each = [run_plan(ready, plan, Gear(rudder_rate=0.2), rtol=1e-6) for _ in range(4)]
    assert [history.fast for history in each][::3] == [False, there]


def test_what_a_session_has_compiled_it_uses():
    plan, own = MANOEUVRES["turning"].plan(SPEED / 7), prepare(TANKER, SPEED)
    script = (
        "from pmmkit.equations import compilation\n"
        "from pmmkit.simulation import simulate\n"
        "from pmmkit.equations import prepare\n"
        "from pmmkit.models import load_model\n"
        f"own = prepare(load_model('kvlcc2-l7'), {SPEED}).structure\n"
        "before = compilation.is_loaded(own)\n"
        f"simulate('kvlcc2-l7', 'turning', speed={SPEED}, compiled=True)\n"
        "assert (before, compilation.is_loaded(own)) == (False, True)"
    )
    subprocess.run([sys.executable, "-c", script], check=True)
    run_plan(own, plan, Gear(rudder_rate=0.2), rtol=1e-6, fast=True)
    assert run_plan(own, plan, Gear(rudder_rate=0.2), rtol=1e-6).fast


def test_steps_of_ships_that_fail_count(monkeypatch):
    """Each of some that tremble takes thousands of steps before it is given up."""
    monkeypatch.setattr(run, "_INTERPRETED", Counter())
    monkeypatch.setattr(run, "is_loaded", lambda _: False)
    monkeypatch.setattr(run, "MOST", run.ROOM)
    ready, plan = prepare(TANKER, SPEED), MANOEUVRES["turning"].plan(SPEED / 7)
    with pytest.raises(SimulationError, match="steps"):
        run_plan(ready, plan, Gear(rudder_rate=0.2), rtol=1e-13)
    assert run._INTERPRETED[ready.structure] >= run.ROOM


def test_what_was_compiled_is_found_on_the_disk(monkeypatch, tmp_path):
    monkeypatch.setenv("PMMKIT_CACHE", str(tmp_path))
    structure = prepare(TANKER, SPEED).structure
    assert not is_compiled.__wrapped__(structure)
    script = (
        "from pmmkit.simulation import simulate\n"
        f"simulate('kvlcc2-l7', 'turning', speed={SPEED}, compiled=True)"
    )
    subprocess.run([sys.executable, "-c", script], check=True)
    assert is_compiled.__wrapped__(structure)


@pytest.mark.slow
@settings(max_examples=20)
@given(
    state=st.tuples(st.floats(0.4, 1.2), st.floats(-0.4, 0.4), st.floats(-0.1, 0.1)),
    delta=st.floats(-0.6, 0.6),
)
@pytest.mark.parametrize("name", [n for n in ships() if n != "mariner"])
def test_a_hull_as_data_is_the_hull_written_out(name, state, delta):
    model = load_model(name)
    scale = math.sqrt(model.ship.L / 7.0)
    u, v, r = state[0] * scale, state[1] * scale, state[2] / scale
    written, data = (prepare(model, scale, generic=generic) for generic in (False, True))
    assert data.structure.products is None
    assert written.accelerations(u, v, r, delta=delta, n=8.0 / scale) == pytest.approx(
        data.accelerations(u, v, r, delta=delta, n=8.0 / scale), rel=1e-11, abs=1e-13
    )


def test_values_and_the_order_of_names_do_not_change_the_structure():
    hull = TANKER.parts["hull_polynomial"]
    turned = replace(hull, values=dict(reversed([(k, 0.0) for k in hull.values])))
    other = TANKER.with_(parts={**TANKER.parts, "hull_polynomial": turned})
    assert prepare(other, 1.0).structure == prepare(TANKER, SPEED).structure


def test_a_signal_that_nothing_gives_is_named_with_the_part_that_would():
    parts = {name: part for name, part in TANKER.parts.items() if name != "propeller"}
    parts["shaft_lag"] = Part(effect="shaft_lag", values={"time_constant": 3.0})
    with pytest.raises(MissingPartError, match="propeller"):
        prepare(TANKER.with_(parts=parts), SPEED)


# Many ships


def test_one_ship_alone_is_the_same_ship_in_a_batch_but_for_last_digits():
    """Lanes have a sine, an exponential and an arctangent of their own."""
    batch = batch_of(TANKER, "turning", speed=SPEED, rudder_deg=35.0)
    drawn = Spread.of(TANKER, SPEED, 0.05)
    values = drawn.draw(3, 0, 40)
    metrics, status = batch.run(drawn.names, values, executor=1)
    assert not status.any()
    for ship in (0, 17, 39):
        alone = TANKER
        for name, value in zip(drawn.names, values[ship].tolist(), strict=True):
            part = "added_mass" if name.endswith("dot") else "hull_polynomial"
            alone = alone.with_values(part, **{name: value})
        found = simulate(alone, speed=SPEED, rudder_deg=35.0).metrics
        for key, value in found.items():
            assert metrics[key][ship] == pytest.approx(value, rel=1e-12, abs=1e-12), key


@pytest.mark.slow
def test_threads_change_no_bit():
    one, four = (
        monte_carlo(TANKER, "zigzag", speed=SPEED, n=1200, spread=0.05, executor=jobs)
        for jobs in (1, 4)
    )
    for name, values in one.metrics.items():
        np.testing.assert_array_equal(values, four.metrics[name])


def test_more_ships_begin_with_the_same_ships():
    few = monte_carlo(TANKER, speed=SPEED, n=50, spread=0.05)
    more = monte_carlo(TANKER, speed=SPEED, n=90, spread=0.05)
    np.testing.assert_array_equal(few.metrics["advance"], more.metrics["advance"][:50])


def test_a_ship_without_bound_spoils_no_other():
    batch = batch_of(TANKER, "turning", speed=SPEED)
    names = ("Yvvv", "Nvvv", "Xvv")
    metrics, status = batch.run(names, np.array([[5.0, -5.0, 3.0], [-1.607, -0.03, -0.04]]))
    assert status.tolist() == [2, 0]
    assert np.isnan(metrics["advance"][0])
    assert metrics["advance"][1] == simulate(TANKER, speed=SPEED).metrics["advance"]


@pytest.mark.slow
def test_an_interval_has_the_width_that_the_slopes_say():
    """Small spread: the standard deviation of the ships is that of the linear theory."""
    many = monte_carlo(TANKER, speed=SPEED, n=4000, spread=0.01)
    found = sensitivities(TANKER, speed=SPEED, spread=0.01)
    for metric in ("advance_L", "tactical_diameter_L", "steady_diameter_L"):
        assert np.std(many.metrics[metric]) == pytest.approx(found.std(metric), rel=0.05)
        assert found.shares(metric).sum() == pytest.approx(1.0)


@pytest.mark.slow
def test_slopes_are_those_of_independent_central_differences():
    """To 1e-6 of the slope, against differences of another order, step and way of changing."""
    names = ("Nr", "Nv", "Yv", "Nvvr")
    found = sensitivities(TANKER, speed=SPEED, names=names)
    for i, name in enumerate(names):
        value = TANKER.parts["hull_polynomial"].values[name]
        h = 4e-4 * abs(value)
        up, down, far_up, far_down = (
            simulate(
                TANKER.with_values("hull_polynomial", **{name: value + k * h}),
                speed=SPEED,
                rtol=1e-12,
            ).metrics
            for k in (1, -1, 2, -2)
        )
        for metric in ("advance", "tactical_diameter", "steady_diameter"):
            slope = 8 * (up[metric] - down[metric]) - (far_up[metric] - far_down[metric])
            assert found.slopes[metric][i] == pytest.approx(slope / (12 * h), rel=1e-6)


@pytest.mark.slow
def test_sobol_indices_of_a_nearly_linear_metric_are_its_shares():
    found = sobol(TANKER, speed=SPEED, spread=0.005, n=1024)
    linear = sensitivities(TANKER, speed=SPEED, spread=0.005)
    shares = dict(zip(linear.names, linear.shares("steady_diameter"), strict=True))
    for name, first, total in zip(
        found.names, found.first["steady_diameter"], found.total["steady_diameter"], strict=True
    ):
        assert first == pytest.approx(shares[name], abs=0.03)
        assert total == pytest.approx(shares[name], abs=0.03)


def test_a_model_without_covariance_asks_for_a_spread():
    with pytest.raises(ModelError, match="spread"):
        monte_carlo(TANKER, speed=SPEED, n=10)


# The catalogue grows by a file

MADE_UP = '''"""A brake that nobody has built."""

from pmmkit.effects import Effect, Parameter
from pmmkit.effects.primitives import fabs


def force(u, rho, L, d, brake):
    return (-0.5 * rho * L * d * brake * u * fabs(u),)


EFFECTS = (
    Effect(
        name="sea_anchor", family="made_up", kind="force", summary="A brake nobody has built.",
        parameters=(Parameter(name="brake", text="force over ½ρLdu²"),), force=force,
        outputs=("X",), remark="this test",
    ),
)
'''


def towed_with_a_brake(size):
    """Forces on the tanker without the effect, and the brake by hand."""
    speeds = np.linspace(0.4, 1.4, 9) * SPEED
    motion = {"u": speeds, "n": np.full(9, 1.7)}
    ready = prepare(TANKER, SPEED)
    water = ready.water_forces(motion)
    unit = 0.5 * TANKER.water.rho * TANKER.ship.L * TANKER.ship.d
    return ForceRecord(
        name="towed",
        motion=motion,
        speed=SPEED,
        std={"X": 1.0},
        forces={"X": water["X"] - unit * size * speeds**2},
    )


@pytest.mark.slow
def test_an_effect_is_one_file_listed_saved_simulated_fitted_and_documented(tmp_path, monkeypatch):
    (tmp_path / "sea_anchor.py").write_text(MADE_UP, encoding="utf-8")
    package = importlib.import_module("pmmkit.effects")
    monkeypatch.setattr(package, "__path__", [*package.__path__, str(tmp_path)])
    CATALOGUE.reload()
    try:
        assert "sea_anchor" in catalogue()
        braked = TANKER.with_(
            parts={**TANKER.parts, "sea_anchor": Part(effect="sea_anchor", values={"brake": 0.01})}
        )
        save_model(braked, tmp_path / "braked.toml")
        again = load_model(tmp_path / "braked.toml")
        assert model_text(again) == model_text(braked)
        plain = simulate(TANKER, speed=SPEED, compiled=False)
        slow, fast = (simulate(again, speed=SPEED, compiled=x) for x in (False, True))
        assert slow.n[0] > plain.n[0]
        assert slow.metrics["advance"] == pytest.approx(fast.metrics["advance"], rel=1e-9)
        brake = fit_to_forces(again, [towed_with_a_brake(0.037)], ["sea_anchor.brake"])
        assert brake.values[0] == pytest.approx(0.037, rel=1e-6)
        assert brake.model.values("sea_anchor") == {"brake": brake.values[0]}
        from pmmkit.actions.jobs.effects import EffectsSettings, effects
        from scripts.documentation.make_docs import effect_page

        assert any(
            item["name"] == "sea_anchor" for item in effects(EffectsSettings()).content["effects"]
        )
        assert "force over ½ρLdu²" in effect_page(catalogue()["sea_anchor"])
    finally:
        sys.modules.pop("pmmkit.effects.sea_anchor", None)
        CATALOGUE.reload()


def test_added_mass_that_depends_on_the_motion_is_solved_for(tmp_path, monkeypatch):
    """A constant Yvdot from an effect of kind mass is the same as one in added_mass."""
    text = MADE_UP.replace("sea_anchor", "extra_mass").replace(
        'outputs=("X",)', 'outputs=("Yvdot",)'
    )
    text = text.replace('kind="force"', 'kind="mass"').replace(
        "-0.5 * rho * L * d * brake * u * fabs(u)", "-brake * rho + 0.0 * fabs(u)"
    )
    (tmp_path / "extra_mass.py").write_text(text, encoding="utf-8")
    package = importlib.import_module("pmmkit.effects")
    monkeypatch.setattr(package, "__path__", [*package.__path__, str(tmp_path)])
    CATALOGUE.reload()
    try:
        for name in ("kvlcc2-l7", "s175"):
            model = load_model(name)
            unit = 0.5 * model.water.rho * model.ship.L**3
            unit *= model.ship.d / model.ship.L if name != "s175" else 1.0
            part = Part(effect="extra_mass", values={"brake": 0.01 * unit / model.water.rho})
            brought = model.with_(parts={**model.parts, "extra_mass": part})
            given = model.values("added_mass")["Yvdot"]
            held = model.with_values("added_mass", Yvdot=given - 0.01)
            if model.convention.coriolis == "separate":
                hull = model.values("hull_polynomial")["Xvr"]
                held = held.with_values("hull_polynomial", Xvr=hull - 0.01)
            speed = model.ship.speed(0.142)
            motion = {"u": 0.8 * speed, "v": -0.2 * speed, "r": 0.4 * speed / model.ship.L}
            one, other = (
                prepare(x, speed).accelerations(**motion, delta=0.3, n=2.0) for x in (brought, held)
            )
            assert one == pytest.approx(other, rel=1e-9, abs=1e-12)
    finally:
        sys.modules.pop("pmmkit.effects.extra_mass", None)
        CATALOGUE.reload()


# The cache


@pytest.mark.slow
def test_where_nothing_can_be_written_it_compiles_all_the_same(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv("PMMKIT_CACHE", str(tmp_path / "file"))
    assert cache_folder() == tmp_path / "file"
    loading = importlib.import_module("pmmkit.equations.compilation")
    module = loading.compiled.__wrapped__(prepare(TANKER, SPEED).structure)
    out = np.zeros(6)
    k = np.array(prepare(TANKER, SPEED).constants)
    module.rates(np.array([0, 0, 0, 1.0, -0.1, 0.05]), 0.2, 10.0, 0.0, k, out)
    expected = prepare(TANKER, SPEED).rates([0, 0, 0, 1.0, -0.1, 0.05], 0.2, 10.0)
    assert out == pytest.approx(expected, rel=1e-12)
