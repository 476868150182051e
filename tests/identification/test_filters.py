"""Kalman filters: their algebra against filterpy, their statistics on simulated ships."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter, predict, update
from scipy.integrate import solve_ivp

import pmmkit as pk
from pmmkit import FreeRecord, identify
from pmmkit.base import DataError, SimulationError
from pmmkit.equations import InputField, prepare
from pmmkit.equations.code_generation import ESTIMATING
from pmmkit.equations.compilation import compiled
from pmmkit.equations.layouts import Constant
from pmmkit.identification import Binding, Prior
from pmmkit.identification.filters import kalman
from pmmkit.identification.record import sensors_of
from pmmkit.models import Part, load_model
from pmmkit.signals import white_noise

TANKER, SPEED = load_model("kvlcc2-l7"), 1.179
LINER = load_model("s175")
BY_WATER = compiled(prepare(TANKER, SPEED).structure, ESTIMATING)
POWERS = ("shallow_water.lambda_Yv", "shallow_water.lambda_Nr")
SHALLOW = TANKER.with_(
    parts={**TANKER.parts, "shallow_water": Part(effect="shallow_water", values={})},
    water=replace(TANKER.water, depth=1.0),
)
SENSORS = {"x": 0.02, "y": 0.02, "psi": math.radians(0.1), "r": math.radians(0.05), "u": 0.01}
FAST = {"x": 1.0, "y": 1.0, "psi": 2e-3, "r": 5e-4, "u": 0.1, "p": 1e-3, "phi": 2e-3}
NAMES = ("Yv", "Nv", "Nr", "Nrrr", "rudder_mmg.aH")


TRACKS = {}
"""What was sailed before, with the model that it was sailed with."""


def track_of(model, *words, **settings):
    """A manoeuvre without noise, simulated once."""
    key = (id(model), *words, *sorted(settings.items()))
    if key not in TRACKS:
        TRACKS[key] = (model, pk.simulate(model, *words, **settings))
    return TRACKS[key][1]


def sailed(
    model=TANKER,
    manoeuvre="zigzag",
    *,
    speed=SPEED,
    seed=0,
    dt=0.1,
    sensors=SENSORS,
    around=None,
    **settings,
) -> FreeRecord:
    """A simulated manoeuvre with white noise of its own on every channel."""
    if manoeuvre == "zigzag":
        settings = {"rudder_deg": 20.0, "switch_deg": 20.0, **settings}
    track = track_of(model, manoeuvre, speed=speed, dt=dt, **(around or {}), **settings)
    noise = np.random.default_rng([seed, 77])
    values = {name: getattr(track, name) for name in sensors if hasattr(track, name)}
    flow = math.radians((around or {}).get("current_direction_deg", 0.0))
    drift = (around or {}).get("current_speed", 0.0)
    ahead, aside = np.cos(track.psi), np.sin(track.psi)
    values["xdot"] = track.u * ahead - track.v * aside + drift * math.cos(flow)
    values["ydot"] = track.u * aside + track.v * ahead + drift * math.sin(flow)
    values["sog"] = np.hypot(values["xdot"], values["ydot"])
    return FreeRecord(
        name=manoeuvre,
        t=track.t,
        delta=track.delta,
        turns=track.n,
        speed=speed,
        measured={
            name: values[name] + std * noise.normal(size=len(track))
            for name, std in sensors.items()
        },
    )


def off(truth: Prior, seed: int) -> Prior:
    """The prior about a point that is drawn from it, so that its spread is true."""
    shift = np.random.default_rng([seed, 5]).normal(size=len(truth.names))
    return replace(truth, mean=truth.mean + truth.std * shift)


def true_prior(names=NAMES, model=TANKER, speed=SPEED, spread=0.2) -> Prior:
    return Prior.of(model, names, speed, spread=spread)


def away(found, truth) -> np.ndarray:
    """Errors over their stated standard deviations."""
    return (found.values - truth) / found.std


# The algebra, against filterpy


def linear_problem(seed: int, m: int = 3, steps: int = 60):
    """Random A, B, forgetting, noise and channels of a system with six states, m parameters."""
    draw = np.random.default_rng(seed)
    n = 6 + m
    F, Q, H = [], [], []
    for _ in range(steps):
        block = np.zeros((n, n))
        block[:6, :6] = np.eye(6) + 0.1 * draw.normal(size=(6, 6))
        block[:6, 6:] = 0.3 * draw.normal(size=(6, m))
        block[6:, 6:] = np.diag(draw.uniform(0.8, 1.0, m))
        F.append(block)
        noise = np.diag(draw.uniform(0.0, 0.02, n))
        noise[:6, :6] += 0.001 * np.outer(block[0, :6], block[0, :6])
        Q.append(noise)
        H.append(draw.normal(size=(2, n)))
    root = draw.normal(size=(n, n))
    return F, Q, H, draw.normal(size=n), root @ root.T + np.eye(n), draw.normal(size=(steps, 2))


def stepped(P, F, Q):
    """Our step of a covariance."""
    ahead = P.copy()
    BY_WATER.predict(ahead, F[:6, :6].copy(), F[:6, 6:].copy(), np.diagonal(F)[6:].copy())
    return ahead + Q


def taken_in(z, P, H, measured, variances):
    """Our corrections, channel by channel."""
    z, P = z.copy(), P.copy()
    gain, left = np.zeros(len(z)), np.zeros(len(z))
    totals = [
        BY_WATER.correct(z, P, h, value - h @ z, variance, math.inf, gain, left)
        for h, value, variance in zip(H, measured, variances, strict=True)
    ]
    return z, P, totals


@pytest.mark.parametrize("m", [0, 1, 4])
def test_filter_and_smoother_are_those_of_filterpy(m):
    F, Q, H, z, P, measured = linear_problem(m, m)
    R, n, steps = (0.3, 0.05), 6 + m, len(F)
    theirs = KalmanFilter(dim_x=n, dim_z=2)
    their_z, their_P = z.copy(), P.copy()
    kept = np.zeros((steps, 2 * n * n + 2 * n + 6 * n + m))
    before, after, covariances = [], [], []
    for t in range(steps):
        if t > 0:
            z, P = F[t] @ z, stepped(P, F[t], Q[t])
            their_z, their_P = predict(their_z, their_P, F[t], Q[t])
            np.testing.assert_allclose(P, their_P, rtol=1e-9, atol=1e-9)
        before.append((z, P))
        z, P, _ = taken_in(z, P, H[t], measured[t], R)
        their_z, their_P = update(their_z, their_P, measured[t], np.diag(R), H[t])
        np.testing.assert_allclose(z, their_z, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(P, their_P, rtol=1e-9, atol=1e-9)
        after.append(z)
        covariances.append(P)
        kept[t] = np.concatenate(
            [
                before[t][0],
                z,
                before[t][1].ravel(),
                P.ravel(),
                F[t][:6, :6].ravel(),
                F[t][:6, 6:].ravel(),
                np.diagonal(F[t])[6:],
            ]
        )
    means, spreads = np.empty((steps, n)), np.empty((steps, n, n))
    BY_WATER.smoothed(kept, n, means, spreads)
    # theirs takes the step from t to t + 1 at t + 1
    expected = theirs.rts_smoother(np.array(after), np.array(covariances), Fs=F, Qs=Q)
    np.testing.assert_allclose(means, expected[0], rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(spreads, expected[1], rtol=1e-9, atol=1e-9)


def test_the_variance_of_a_residual_is_that_of_channel_and_state():
    _, _, H, z, P, measured = linear_problem(3)
    total = taken_in(z, P, H[0][:1], measured[0][:1], [0.3])[2]
    assert total == pytest.approx([H[0][0] @ P @ H[0][0] + 0.3], rel=1e-12)


def test_covariances_stay_positive_over_thousands_of_badly_scaled_steps():
    """States from kilometres to microradians; the truth is a square-root filter by QR."""
    m, draw = 3, np.random.default_rng(1)
    n = 6 + m
    size = np.array([1e4, 1e4, 1.0, 10.0, 1.0, 1e-4, 1e-6, 1e2, 1e-3])
    root = np.diag(size)
    P = root @ root.T
    F = np.eye(n)
    F[:6, :6] -= 0.05 * np.diag(draw.uniform(0.1, 1.0, 6))
    F[:6, :] += 0.01 * np.triu(draw.normal(size=(6, n)), 1)
    F = size[:, None] * F / size
    Q = np.diag((1e-3 * size) ** 2)
    Q[6:, 6:] = 0.0
    for t in range(4000):
        P = stepped(P, F, Q)
        root = np.linalg.qr(np.hstack([F @ root, np.sqrt(Q)]).T, mode="r").T
        h = np.zeros(n)
        h[t % 6] = 1.0
        variance = (1e-5 * size[t % 6]) ** 2
        _, P, _ = taken_in(np.zeros(n), P, [h], [0.0], [variance])
        block = np.zeros((n + 1, n + 1))
        block[0, 0], block[0, 1:], block[1:, 1:] = math.sqrt(variance), 0.0, root.T
        block[1:, 0] = root.T @ h
        root = np.linalg.qr(block, mode="r")[1:, 1:].T
        np.testing.assert_array_equal(P, P.T)
        if t % 500 == 499:
            true = root @ root.T
            std = np.sqrt(np.diagonal(true))
            np.testing.assert_allclose(P / np.outer(std, std), true / np.outer(std, std), atol=1e-6)
            assert np.linalg.eigvalsh(P / np.outer(std, std))[0] > 0.0


# The motion between two instants


def by_scipy(model, speed, t, inputs, start):
    """States at instants by DOP853, controls straight lines between them."""
    ready = prepare(model, speed)
    states = [np.array(start)]
    for i in range(len(t) - 1):

        def rates(time, y, i=i):
            share = (time - t[i]) / (t[i + 1] - t[i])
            delta, turns = inputs[i, :2] + share * (inputs[i + 1, :2] - inputs[i, :2])
            return ready.rates(y, delta, turns)

        states.append(
            solve_ivp(
                rates, (t[i], t[i + 1]), states[-1], method="DOP853", rtol=1e-12, atol=1e-13
            ).y[:, -1]
        )
    return np.array(states)


def steered(model, speed, size=12):
    """Uneven instants, moving controls and a state off the straight course."""
    draw = np.random.default_rng(4)
    pace = speed / model.ship.L
    t = np.cumsum(draw.uniform(0.05, 0.3, size)) / pace
    turns = prepare(model, speed).self_propulsion()
    inputs = np.zeros((size, len(InputField)))
    inputs[:, 0] = draw.uniform(-0.5, 0.5, size)
    inputs[:, 1] = turns * draw.uniform(0.9, 1.1, size)
    start = [10.0, -5.0, 0.4, 0.9 * speed, 0.05 * speed, -0.2 * pace]
    return t, inputs, start + [0.2 * pace, 0.05] * model.rolls


@pytest.mark.slow
@pytest.mark.parametrize(("model", "speed"), [(TANKER, SPEED), (LINER, 9.0)])
def test_the_motion_in_a_window_is_that_of_another_integrator(model, speed):
    ready = prepare(model, speed)
    t, inputs, start = steered(model, speed)
    truth = by_scipy(model, speed, t, inputs, start)
    later = by_scipy(model, speed, t[7:], inputs[7:], np.array(start) * 0.9)
    functions, k = compiled(ready.structure, ESTIMATING), np.array(ready.constants)
    pace, errors = speed / model.ship.L, []
    for longest in (0.1, 0.05, 0.01):
        out = np.empty_like(truth)
        functions.windows(
            t,
            inputs,
            np.array([0, 7, len(t)]),
            np.array([start, np.array(start) * 0.9]),
            k,
            longest / pace,
            out,
        )
        scale = np.ptp(truth, axis=0)
        errors.append(np.max(np.abs(out - np.concatenate([truth[:7], later])) / scale))
    assert errors[1] < 3e-5
    assert errors[2] < 2e-6
    assert errors[1] / errors[2] > 10.0


def with_other(model, name, value):
    """The model with another value under such a name."""
    effect, dot, own = name.partition(".")
    home = next(
        part for part in model.parts if effect in model.parts[part].values or part == effect
    )
    return model.with_values(home, **{own if dot else name: value})


PARAMETERS = ("Yv", "Nrrr", "Xvr", "Yvdot", "rudder_mmg.aH")


def test_slopes_over_states_and_parameters_are_those_of_another_integrator():
    """Central differences of DOP853; the parameters are changed in the model itself."""
    t, inputs, start = steered(TANKER, SPEED, 2)
    binding = Binding.of(TANKER, PARAMETERS, SPEED)
    m = len(PARAMETERS)
    A, B, y = np.zeros((6, 6)), np.zeros((6, m)), np.zeros(6)
    steps = np.concatenate([np.full(6, 1e-6), 1e-4 * np.abs(binding.mean)])
    lines = (binding.base, binding.starts, binding.places, binding.slopes)
    room = (np.zeros(len(binding.base)), np.zeros((6, 6)))
    system = (t, inputs, *lines, 0.05, steps, *room)
    lost = BY_WATER.linearised(system, 1, np.array(start), np.zeros(m), y, A, B)
    assert lost == 0
    assert y == pytest.approx(by_scipy(TANKER, SPEED, t, inputs, start)[-1], rel=1e-8)

    def end(start=start, **changes):
        model = TANKER
        for name, value in changes.items():
            model = with_other(model, name, value)
        return by_scipy(model, SPEED, t, inputs, start)[-1]

    for j in range(6):
        step = np.zeros(6)
        step[j] = 1e-3
        slope = (end(np.array(start) + step) - end(np.array(start) - step)) / 2e-3
        np.testing.assert_allclose(A[:, j], slope, rtol=2e-4, atol=2e-5 * np.max(np.abs(slope)))
    for j, name in enumerate(PARAMETERS):
        step = 1e-3 * abs(binding.mean[j])
        up, down = (end(**{name: binding.mean[j] + s * step}) for s in (1.0, -1.0))
        slope = (up - down) / (2.0 * step)
        np.testing.assert_allclose(B[:, j], slope, rtol=2e-3, atol=1e-3 * np.max(np.abs(slope)))


@pytest.mark.parametrize("kind", [100, 101, 102])
def test_slopes_of_the_velocity_over_ground(kind):
    k = np.zeros(len(Binding.of(TANKER, (), SPEED).base))
    k[Constant.current_x], k[Constant.current_y] = 0.3, -0.2
    z, h = np.array([5.0, 6.0, 2.1, 1.1, -0.3, 0.05, 7.0]), np.zeros(7)

    def by_hand(z):
        water = (z[3] + 1j * z[4]) * np.exp(1j * z[2])
        ground = water + 0.3 - 0.2j
        return {100: ground.real, 101: ground.imag, 102: abs(ground)}[kind]

    assert BY_WATER.expected(kind, z, k, h) == pytest.approx(by_hand(z), rel=1e-12)
    steps = 1e-5 * np.eye(7)
    slopes = [(by_hand(z + step) - by_hand(z - step)) / 2e-5 for step in steps]
    assert h == pytest.approx(slopes, abs=1e-9)


# Constants over parameters


def all_parameters(model):
    """Every number of a model by the name under which it may be looked for."""
    names = []
    for effect, part in model.parts.items():
        for name, value in part.values.items():
            if isinstance(value, float) and value != 0.0:
                derivative = effect in ("hull_polynomial", "added_mass")
                names.append(name if derivative else f"{effect}.{name}")
    return names


@pytest.mark.slow
@pytest.mark.parametrize(
    ("model", "speed"),
    [(TANKER, SPEED), (LINER, 9.0), (SHALLOW, SPEED)],
    ids=["tanker", "liner", "shallow"],
)
def test_constants_are_those_of_a_model_with_other_values(model, speed):
    names = [name for name in all_parameters(model) if not name.startswith("shallow_water.")]
    binding = Binding.of(model, names, speed)
    for j, name in enumerate(names):
        other = with_other(model, name, 1.37 * binding.mean[j])
        expected = prepare(other, speed).k
        moved = binding.mean.copy()
        moved[j] *= 1.37
        np.testing.assert_allclose(
            binding.constants(moved), np.array(expected, float), rtol=1e-9, atol=1e-12, err_msg=name
        )
        gear = name.endswith(("rate_deg_s", "max_deg"))
        assert gear or np.any(binding.constants(moved) != binding.base), name


@pytest.mark.parametrize("name", POWERS)
def test_a_parameter_that_bends_the_constants_is_refused(name):
    with pytest.raises(DataError, match=f"{name} enters .* no straight line.* fit_to_forces"):
        Binding.of(SHALLOW, [name], SPEED)


def test_currents_are_parameters_too():
    binding = Binding.of(TANKER, ["current_y", "Yv", "current_x"], SPEED)
    k = binding.constants(binding.mean + np.array([0.2, 0.0, -0.1]))
    assert (k[Constant.current_x], k[Constant.current_y]) == pytest.approx((-0.1, 0.2))


# The prior


def test_the_prior_is_the_spread_where_nothing_is_known():
    prior = Prior.of(TANKER, ["Yv", "Nr", "current_x"], SPEED, spread={"Nr": 0.1})
    assert prior.std == pytest.approx([0.3 * 0.315, 0.1 * 0.049, 0.1 * SPEED])
    assert prior.mean == pytest.approx([-0.315, -0.049, 0.0])
    assert Prior.of(TANKER, ["Yv"], SPEED, spread=1).std == pytest.approx([0.315])
    with pytest.raises(DataError, match="at least one"):
        Prior.of(TANKER, [], SPEED)


def test_the_prior_is_the_covariance_of_the_model_where_it_has_one():
    block = np.array([[4e-4, 1e-4], [1e-4, 9e-4]])
    known = replace(TANKER, covariance=block, covariance_names=("Nr", "Yv"))
    prior = Prior.of(known, ["Yv", "Nv", "Nr"], SPEED)
    expected = np.array([[9e-4, 0, 1e-4], [0, (0.3 * 0.137) ** 2, 0], [1e-4, 0, 4e-4]])
    np.testing.assert_allclose(prior.covariance, expected, rtol=1e-12)
    assert "2 of 3" in prior.origin
    spread = Prior.of(known, ["Yv", "Nr"], SPEED, spread=0.1)
    np.testing.assert_allclose(spread.std, [0.0315, 0.0049])
    some = Prior.of(known, ["Yv", "Nr"], SPEED, spread={"Yv": 0.5})
    np.testing.assert_allclose(some.covariance, np.diag([(0.5 * 0.315) ** 2, 4e-4]))


def test_a_value_of_zero_has_the_size_of_the_smallest_of_its_channel():
    model = TANKER.with_values("hull_polynomial", Yvvvv=0.0)
    sizes = [abs(x) for name, x in TANKER.values("hull_polynomial").items() if name[0] == "Y"]
    sizes += [abs(x) for name, x in TANKER.values("added_mass").items() if name[0] == "Y" and x]
    assert Prior.of(model, ["Yvvvv"], SPEED).std == pytest.approx([0.3 * min(sizes)])


# Sensors


def test_noise_is_told_from_the_record():
    record = sailed(seed=3)
    found = sensors_of([record], {"x": 0.5})
    assert found["x"] == 0.5
    assert found["psi"] == pytest.approx(SENSORS["psi"], rel=0.1)
    assert found["y"] == pytest.approx(SENSORS["y"], rel=0.1)
    clean = sailed(sensors=dict.fromkeys(SENSORS, 0.0))
    for name, std in sensors_of([clean], {}).items():
        assert 5e-5 < std / np.ptp(clean.measured[name]) < 2e-3, name
    assert white_noise(record.measured["r"]) == pytest.approx(SENSORS["r"], rel=0.1)
    short = record.cut(0.0, 0.5)
    with pytest.raises(DataError, match=r"noise of u .*sensors="):
        sensors_of([short.only(["u"])], {})


# Ships that are known


def test_a_tanker_is_identified_and_its_residuals_are_white():
    truth = true_prior()
    found = kalman(TANKER, [sailed()], off(truth, 1), sensors=SENSORS, roughness=0.0)
    assert np.all(np.abs(away(found, truth.mean)) < 3.5)
    assert np.all(found.std[:3] < 0.05 * truth.std[:3])
    assert found.converged
    (innovations,) = found.innovations.values()
    count = len(innovations.residuals)
    nis = np.mean(innovations.normalised**2, axis=0)
    assert np.all(np.abs(nis - 1.0) < 4.0 * math.sqrt(2.0 / count))
    lagged = innovations.normalised[1:] * innovations.normalised[:-1]
    assert np.all(np.abs(np.mean(lagged, axis=0)) < 4.0 / math.sqrt(count))


@pytest.mark.slow
def test_intervals_of_95_percent_hold_95_percent():
    truth = true_prior()
    errors = np.array(
        [
            away(
                kalman(
                    TANKER, [sailed(seed=seed)], off(truth, seed), sensors=SENSORS, roughness=0.0
                ),
                truth.mean,
            )
            for seed in range(24)
        ]
    )
    assert 0.88 <= np.mean(np.abs(errors) < 1.96) <= 0.995
    assert 0.7 < np.mean(errors**2) < 1.4


@pytest.mark.slow
@pytest.mark.parametrize("method", ["ekf", "ukf"])
def test_a_rolling_ship_is_identified_in_a_turn(method):
    names = ("Yv", "Nv", "Nr", "Kv", "Kp")
    names = tuple(name for name in names if name in LINER.parts["hull_polynomial"].values)
    truth = true_prior(names, LINER, 9.0)
    settings = {"speed": 9.0, "sensors": FAST, "dt": 0.5}
    records = [sailed(LINER, "turning", rudder_deg=20.0, **settings), sailed(LINER, **settings)]
    found = kalman(LINER, records, off(truth, 2), sensors=FAST, roughness=0.0, method=method)
    assert len(names) >= 4
    assert np.all(np.abs(away(found, truth.mean)) < 3.5)
    assert np.all(found.std < 0.2 * truth.std)
    for item in found.innovations.values():
        assert np.nanmean(item.normalised**2) == pytest.approx(1.0, abs=0.1)


def test_both_filters_agree():
    record, prior = sailed(seed=4), off(true_prior(spread=0.1), 3)
    one, other = (
        kalman(TANKER, [record], prior, sensors=SENSORS, roughness=1e-3, method=method)
        for method in ("ekf", "ukf")
    )
    assert np.all(np.abs(one.values - other.values) < 0.3 * one.std)
    assert one.std == pytest.approx(other.std, rel=0.1)


@pytest.mark.slow
def test_the_roughness_of_a_wrong_model_is_found():
    """Quadratic damping that the model lacks makes the filter distrust it."""
    wrong = TANKER.with_values("hull_polynomial", Yvvv=0.0, Nvvr=0.0, Xvr=0.0)
    prior = off(true_prior(("Yv", "Nv")), 1)
    right = kalman(TANKER, [sailed()], prior, sensors=SENSORS)
    poor = kalman(wrong, [sailed()], prior, sensors=SENSORS)
    assert right.roughness <= 1e-4
    assert poor.roughness >= 3e-3
    assert np.all(poor.std > 3.0 * right.std)


def test_wild_values_do_not_matter():
    truth, record, draw = true_prior(), sailed(seed=6), np.random.default_rng(1)
    wild = {name: values.copy() for name, values in record.measured.items()}
    for name, values in wild.items():
        at = 1 + draw.choice(len(values) - 1, 25, replace=False)
        values[at] += 50.0 * SENSORS[name] * draw.choice([-1.0, 1.0], 25)
    settings = {"sensors": SENSORS, "roughness": 0.0}
    prior = off(truth, 6)
    clean = kalman(TANKER, [record], prior, **settings)
    gated = kalman(TANKER, [record.with_(measured=wild)], prior, **settings)
    ruined = kalman(TANKER, [record.with_(measured=wild)], prior, gate=1e6, **settings)
    assert np.all(np.abs(gated.values - clean.values) < 0.5 * clean.std)
    assert gated.innovations["zigzag"].gated.sum() == 5 * 25
    assert np.max(np.abs(ruined.values - truth.mean) / clean.std) > 5.0
    assert ruined.lack.found
    assert np.all(np.abs(away(ruined, truth.mean)) < 2.0)


def test_a_wild_first_position_does_not_matter():
    truth, record = true_prior(), sailed(seed=6)
    wild = {name: values.copy() for name, values in record.measured.items()}
    wild["x"][0] += 50.0 * SENSORS["x"]
    wild["psi"][0] -= 50.0 * SENSORS["psi"]
    found = kalman(
        TANKER, [record.with_(measured=wild)], off(truth, 6), sensors=SENSORS, roughness=0.0
    )
    assert np.all(np.abs(away(found, truth.mean)) < 3.5)
    assert found.innovations["zigzag"].gated.sum() <= 4


def test_missing_samples_do_not_matter():
    truth, record = true_prior(), sailed(seed=7)
    gaps = {name: values.copy() for name, values in record.measured.items()}
    gaps["x"][200:500] = gaps["y"][200:500] = np.nan
    gaps["psi"][600:700] = np.nan
    gaps["u"][:50] = np.nan
    gaps["r"][::2] = np.nan
    found = kalman(
        TANKER, [record.with_(measured=gaps)], off(truth, 7), sensors=SENSORS, roughness=0.0
    )
    assert np.all(np.abs(away(found, truth.mean)) < 3.5)
    innovations = found.innovations["zigzag"]
    missing = np.stack([np.isnan(gaps[name]) for name in innovations.names], axis=1)
    np.testing.assert_array_equal(np.isnan(innovations.residuals), missing)


@pytest.mark.parametrize(
    "channels", [("x", "y", "psi"), ("psi", "r", "u"), ("xdot", "ydot", "psi"), ("sog", "r", "psi")]
)
def test_some_channels_are_enough(channels):
    sensors = {**SENSORS, "xdot": 0.01, "ydot": 0.01, "sog": 0.01}
    sensors = {name: sensors[name] for name in channels}
    truth = true_prior()
    found = kalman(
        TANKER, [sailed(seed=8, sensors=sensors)], off(truth, 8), sensors=sensors, roughness=0.0
    )
    assert np.all(np.abs(away(found, truth.mean)) < 3.5)
    assert np.all(found.std[:3] < 0.2 * truth.std[:3])


@pytest.mark.parametrize("method", ["ekf", "ukf"])
def test_a_heading_may_jump_by_whole_turns(method):
    record = sailed(manoeuvre="turning", rudder_deg=35.0, seed=9)
    wrapped = dict(record.measured)
    wrapped["psi"] = np.angle(np.exp(1j * wrapped["psi"]))
    assert np.ptp(record.measured["psi"]) > 2.0 * math.pi
    found = [
        kalman(
            TANKER, [item], off(true_prior(), 9), sensors=SENSORS, roughness=0.0, method=method
        ).values
        for item in (record, record.with_(measured=wrapped))
    ]
    assert found[1] == pytest.approx(found[0], rel=1e-9)


AREAS = {"AF": 500.0, "AL": 2500.0}
FLOW = {"current_speed": 0.12, "current_direction_deg": 60.0}
OVER_GROUND = {
    "positions": {"x": 0.02, "y": 0.02, "psi": 2e-3, "r": 1e-3},
    "velocities": {"xdot": 0.01, "ydot": 0.01, "psi": 2e-3, "r": 1e-3},
    "speed": {"sog": 0.01, "psi": 2e-3, "r": 1e-3},
}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("channels", "method"),
    [*((name, "ekf") for name in OVER_GROUND), ("positions", "ukf"), ("velocities", "ukf")],
)
def test_a_current_is_identified(channels, method):
    sensors = OVER_GROUND[channels]
    names = ("Yv", "Nr", "current_x", "current_y")
    truth = true_prior(names)
    truth = replace(truth, mean=np.array([*truth.mean[:2], 0.06, 0.12 * math.sin(math.pi / 3)]))
    prior = replace(truth, mean=np.array([1.1, 1.1, 0.0, 0.0]) * truth.mean)
    errors = np.array(
        [
            away(
                kalman(
                    TANKER,
                    [sailed(seed=seed, sensors=sensors, around=FLOW)],
                    prior,
                    sensors=sensors,
                    roughness=0.0,
                    method=method,
                ),
                truth.mean,
            )
            for seed in range(8)
        ]
    )
    assert np.max(np.abs(errors)) < 4.0
    assert 0.4 < np.mean(errors**2) < 2.0


@pytest.mark.slow
def test_a_drifting_ship_feels_the_wind_less_the_current():
    """A window is the simulated drift in wind and current, both over ground."""
    windy = LINER.with_(parts={**LINER.parts, "wind": Part(effect="wind", values=AREAS)})
    around = {
        "wind_speed": 20.0,
        "wind_direction_deg": 70.0,
        "current_speed": 3.0,
        "current_direction_deg": 200.0,
    }
    track = pk.simulate(windy, speed=9.0, rudder_deg=10.0, dt=0.5, duration=200.0, **around)
    flow = 3.0 * np.exp(1j * math.radians(200.0))
    binding = Binding.of(windy, ["current_x", "current_y"], 9.0)
    k = binding.constants(np.array([flow.real, flow.imag]))
    functions = compiled(binding.equations.structure, ESTIMATING)
    functions.complete(k)
    inputs = np.zeros((len(track), len(InputField)))
    inputs[:, 0], inputs[:, 1] = track.delta, track.n
    inputs[:, 3], inputs[:, 4] = 20.0, math.radians(70.0)
    start = [getattr(track, name)[0] for name in binding.states]
    out = np.empty((len(track), len(start)))
    functions.windows(track.t, inputs, np.array([0, len(track)]), np.array([start]), k, 0.5, out)
    assert out[-1, 0] == pytest.approx(track.x[-1], abs=0.05)
    assert out[-1, 1] == pytest.approx(track.y[-1], abs=0.05)
    assert out[-1, 2] == pytest.approx(track.psi[-1], abs=1e-4)


def test_what_is_not_excited_is_named_and_left_at_the_prior():
    record = sailed(rudder_deg=3.0, switch_deg=3.0, seed=10)
    prior = off(true_prior(("Nv", "Nr", "Nrrr", "Xvvvv")), 10)
    found = identify(TANKER, [record], method="ekf", prior=prior, sensors=SENSORS, roughness=0.0)
    assert found.unseen == ("Nrrr", "Xvvvv")
    hull = found.model.values("hull_polynomial")
    assert [hull[name] for name in found.unseen] == pytest.approx(prior.mean[2:], rel=1e-12)
    assert [hull[name] for name in ("Nv", "Nr")] == pytest.approx(found.values[:2], rel=1e-12)


def test_records_are_carried_on():
    """Two records in one call are the second with what the first taught as its prior."""
    first, second = sailed(seed=11), sailed(seed=12, rudder_deg=-15.0).with_(name="other")
    settings = {"sensors": SENSORS, "roughness": 1e-4, "wander": dict.fromkeys(NAMES, 1e-12)}
    prior = off(true_prior(), 11)
    together = kalman(TANKER, [first, second], prior, **settings)
    one = kalman(TANKER, [first], prior, **settings)
    learnt = replace(prior, mean=one.values, covariance=one.covariance)
    two = kalman(TANKER, [second], learnt, **settings)
    assert together.values == pytest.approx(two.values, rel=1e-7)
    np.testing.assert_allclose(
        together.covariance / np.outer(two.std, two.std),
        two.covariance / np.outer(two.std, two.std),
        atol=1e-5,
    )
    assert np.all(together.std < one.std)
    assert set(together.histories) == {"zigzag", "other"}


def test_a_parameter_that_wanders_is_followed():
    """Nr grows by a half over the record; the truth is integrated by scipy."""
    record = sailed(sensors={"psi": 1e-4, "r": 1e-4, "u": 1e-3}, dt=0.2, seed=13)
    binding = Binding.of(TANKER, ["Nr"], SPEED)
    functions = BY_WATER
    end = record.t[-1]

    def rates(t, y):
        k = binding.constants(binding.mean * (1.0 + 0.5 * t / end))
        functions.complete(k)
        out = np.empty(6)
        delta, turns = (np.interp(t, record.t, x) for x in (record.delta, record.turns))
        functions.rates(y, delta, turns, 0.0, k, out)
        return out

    truth = solve_ivp(
        rates,
        (0.0, end),
        [0, 0, 0, SPEED, 0, 0],
        t_eval=record.t,
        rtol=1e-8,
        atol=1e-10,
        max_step=0.2,
    ).y
    draw = np.random.default_rng(2).normal
    sensors = {"psi": 1e-3, "r": 1e-3, "u": 1e-2}
    moved = record.with_(
        measured={
            name: truth[{"psi": 2, "u": 3, "r": 5}[name]] + std * draw(size=len(record))
            for name, std in sensors.items()
        }
    )
    prior = true_prior(("Nr",))
    settings = {"sensors": sensors, "roughness": 0.0}
    found = kalman(TANKER, [moved], prior, wander={"Nr": 0.02 * 0.049}, **settings)
    history, spread = found.histories["zigzag"][:, 6], found.spreads["zigzag"][:, 6]
    ramp = -0.049 * (1.0 + 0.5 * record.t / end)
    late = record.t > 0.3 * end
    assert np.sqrt(np.mean((history - ramp)[late] ** 2)) < 0.1 * 0.049
    assert np.mean(np.abs(history - ramp)[late] < 3.0 * np.sqrt(spread[late])) > 0.9
    held = kalman(TANKER, [moved], prior, **settings).histories["zigzag"][:, 6]
    assert abs(held[-1] - ramp[-1]) > 3.0 * abs(history[-1] - ramp[-1])


@pytest.mark.slow
@pytest.mark.parametrize("method", ["ekf", "ukf"])
def test_the_same_record_gives_the_same_bits(method):
    one, other = (
        kalman(TANKER, [sailed(seed=14)], off(true_prior(), 14), method=method) for _ in range(2)
    )
    np.testing.assert_array_equal(one.values, other.values)
    np.testing.assert_array_equal(one.covariance, other.covariance)


@pytest.mark.slow
def test_a_rudder_of_the_wrong_sign_shows():
    """In the residuals where the noise is held; else as process noise that no ship has."""
    record = sailed(seed=15)
    turned = record.with_(delta=-record.delta)
    prior = true_prior()
    held = kalman(TANKER, [turned], prior, sensors=SENSORS, roughness=1e-3)
    innovations = held.innovations["zigzag"]
    assert np.mean(innovations.residuals**2 / innovations.variances) > 1000.0
    assert np.mean(innovations.gated) > 0.3
    right, wrong = (kalman(TANKER, [x], prior, sensors=SENSORS) for x in (record, turned))
    assert right.roughness <= 1e-4
    assert wrong.roughness >= 1e-2
    assert wrong.log_likelihood < right.log_likelihood - 500.0
    assert np.max(np.abs(wrong.values - prior.mean) / prior.std) > 4.0


def test_a_filter_that_loses_the_ship_says_what_to_check():
    runaway = TANKER.with_values("hull_polynomial", Xuu=50.0)
    with pytest.raises(SimulationError, match="signs of rudder and heading"):
        kalman(runaway, [sailed(seed=15)], true_prior(), sensors=SENSORS, roughness=0.0)


def test_what_cannot_be_filtered_is_refused():
    record = sailed(seed=16)
    with pytest.raises(DataError, match="no record"):
        kalman(TANKER, [], true_prior())
    rolling = record.with_(measured={**record.measured, "phi": np.zeros(len(record))})
    with pytest.raises(DataError, match="no state phi"):
        kalman(TANKER, [rolling], true_prior(), sensors={**SENSORS, "phi": 0.01})
    with pytest.raises(DataError, match="one length"):
        record.with_(delta=record.delta[1:])
    with pytest.raises(DataError, match="ascend"):
        record.with_(t=record.t[::-1])
    with pytest.raises(DataError, match="not known at all instants"):
        record.with_(delta=np.where(record.t > 5.0, np.nan, record.delta))
    with pytest.raises(DataError, match="channels speed"):
        record.with_(measured={"speed": record.t})
    with pytest.raises(DataError, match="has no phi"):
        record.only(["x", "phi"])


def test_an_added_mass_that_a_prior_cannot_hold_is_an_error():
    prior = true_prior(("Yvdot",))
    heavy = replace(prior, mean=-8.0 * prior.mean)
    with pytest.raises(SimulationError, match=r"mass matrix|loses the motion"):
        kalman(TANKER, [sailed(seed=17)], heavy, sensors=SENSORS, roughness=0.0)
