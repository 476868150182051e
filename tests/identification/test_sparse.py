"""Sparse regression of hull derivatives from measured forces."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from pmmkit.base import PmmkitError
from pmmkit.effects import Regressors, State
from pmmkit.equations import prepare
from pmmkit.identification.forces import ForceRecord
from pmmkit.identification.sparse.regression import look_for_collinearity, sparse_regression
from pmmkit.identification.sparse.request import physics_groups
from pmmkit.identification.sparse.rows import averaged, equations
from pmmkit.models import load_model
from pmmkit.simulation import simulate

RHO, L, D = 1000.0, 7.0, 0.46
AH, XH, XR, LR = 0.312, -0.464, -0.5, -0.71
TRUTH = {
    "Yv": -0.30,
    "Yr": 0.08,
    "Yv|v|": -0.9,
    "Yvrr": -0.4,
    "Nv": -0.13,
    "Nr": -0.05,
    "Nvvr": -0.30,
    "Nr|r|": -0.02,
}
LIBRARY = "Yv Yr Yv|v| Yr|r| Yvvr Yvrr Nv Nr Nv|v| Nr|r| Nvvr Nvrr"


def by_hand(m, hull=TRUTH):
    """Side force and yaw moment of KVLCC2 as the MMG papers write them, from the motion alone.

    Yasukawa and Yoshimura (2015), equations 7 to 26 with the values of the 7 m model; the hull
    polynomial is that of `hull`.
    """
    u, v, r, vdot, rdot, n = (m[x] for x in ("u", "v", "r", "vdot", "rdot", "n"))
    U = np.hypot(u, v)
    beta, vp, rp = np.arctan2(-v, u), v / U, r * L / U
    at_propeller = beta + 0.48 * rp
    more = np.where(at_propeller > 0, 1.6, 1.1) - 1
    wake = 1 - (1 - 0.4) * (1 + (1 - np.exp(-2.0 * np.abs(at_propeller))) * more)
    uP = (1 - wake) * u
    J = uP / (n * 0.216)
    KT = 0.2931 - 0.2753 * J - 0.1385 * J**2
    eta = 0.216 / 0.345
    jet = 1 + 0.5 * (np.sqrt(1 + 8 * KT / (np.pi * J**2)) - 1)
    uR = 1.09 * uP * np.sqrt(eta * jet**2 + 1 - eta)
    inflow = beta - LR * rp
    vR = U * np.where(inflow > 0, 0.64, 0.395) * inflow
    FN = 0.5 * RHO * 0.0539 * (uR**2 + vR**2) * 2.747 * np.sin(-np.arctan2(vR, uR))
    products = {"v": vp, "r": rp, "|v|": np.abs(vp), "|r|": np.abs(rp)}

    def polynomial(channel):
        total = 0.0
        for name, value in hull.items():
            if name[0] == channel:
                parts = name[1:].replace("|v|", "V").replace("|r|", "R")
                lookup = {"v": "v", "r": "r", "V": "|v|", "R": "|r|"}
                total = total + value * np.prod([products[lookup[x]] for x in parts], axis=0)
        return total

    mass = 0.5 * RHO * L**2 * D
    Y = 0.5 * RHO * L * D * U**2 * polynomial("Y") - (1 + AH) * FN
    Y = Y - 0.223 * mass * vdot - 0.022 * mass * u * r
    N = 0.5 * RHO * L**2 * D * U**2 * polynomial("N") - (XR + AH * XH) * L * FN
    return {"Y": Y, "N": N - 0.011 * mass * L**2 * rdot}


def captive(speed=1.2, steps=300, period=12.5, cycles=3):
    """Motions of a programme: drift, pure sway, pure yaw and yaw with drift, each twice or more."""
    t = np.linspace(0.0, cycles * period, steps)
    w = 2 * np.pi / period
    zero = np.zeros(steps)
    still = {"u": zero + speed, "v": zero, "r": zero, "vdot": zero, "rdot": zero}
    found = {}
    for deg in (-16, -10, -4, 4, 10, 16):
        beta = np.radians(deg)
        found[f"drift {deg}"] = still | {
            "u": zero + speed * np.cos(beta),
            "v": zero - speed * np.sin(beta),
        }
    for top in (0.1, 0.2, 0.35):
        found[f"sway {top}"] = still | {"v": top * np.sin(w * t), "vdot": top * w * np.cos(w * t)}
    for top in (0.03, 0.06, 0.1):
        found[f"yaw {top}"] = still | {"r": top * np.sin(w * t), "rdot": top * w * np.cos(w * t)}
        for deg in (8, -12):
            beta = np.radians(deg)
            found[f"yaw {top} drift {deg}"] = found[f"yaw {top}"] | {
                "u": zero + speed * np.cos(beta),
                "v": zero - speed * np.sin(beta),
            }
    return {name: motion | {"n": zero + 1.7} for name, motion in found.items()}


def measured(noise=1.0, seed=3, hull=TRUTH, moved=0.0, **kwargs):
    """Records with white noise and an offset of each run, in parts of 2 N and 5 N m."""
    rng = np.random.default_rng(seed)
    std = {"Y": 2.0 * max(noise, 1e-6), "N": 5.0 * max(noise, 1e-6)}
    records = []
    for name, motion in captive(**kwargs).items():
        forces = {
            channel: force
            + std[channel] * (noise > 0) * (rng.normal(size=len(force)) + 0.1 * rng.normal())
            for channel, force in by_hand(motion, hull).items()
        }
        seen = {
            key: x + moved * rng.normal(size=len(x)) * {"v": 1.0, "r": 1.0 / L}.get(key, 0.0)
            for key, x in motion.items()
        }
        records.append(ForceRecord(name=name, motion=seen, forces=forces, std=std, speed=1.2))
    return records


@pytest.fixture(scope="module")
def ship():
    """KVLCC2 without the sway and yaw terms of its hull."""
    model = load_model("kvlcc2-l7")
    hull = model.parts["hull_polynomial"]
    surge = {name: value for name, value in hull.values.items() if name[0] == "X"}
    return model.with_(parts={**model.parts, "hull_polynomial": replace(hull, values=surge)})


@pytest.fixture(scope="module")
def found(ship):
    return sparse_regression(ship, measured(), LIBRARY, bags=60, fixed=["Yvdot", "Nrdot"])


@pytest.mark.slow
def test_exact_forces_give_back_their_terms_and_no_others(ship):
    exact = sparse_regression(
        ship, measured(noise=0.0), LIBRARY + " Yvvv Nvvv", bags=10, method="stepwise"
    )
    assert set(exact.table.names) == set(TRUTH)
    assert exact.table.at() == pytest.approx(TRUTH, rel=1e-9)
    assert all(exact.share[name] == (name in TRUTH) for name in exact.names)


@pytest.mark.slow
def test_elimination_finds_the_terms_too(ship):
    exact = sparse_regression(
        ship, measured(noise=0.0), LIBRARY + " Yvvv Nvvv", bags=10, method="elimination"
    )
    assert exact.table.at() == pytest.approx(TRUTH, rel=1e-9)
    noisy = sparse_regression(ship, measured(), LIBRARY, bags=40, method="elimination")
    assert noisy.paths == ()
    assert set(noisy.table.names) == set(TRUTH)
    assert noisy.table.at() == pytest.approx(TRUTH, rel=0.03)
    errors = [x for own in noisy.held_out.values() for x in own.values()]
    assert min(errors) > 0.85
    assert max(errors) < 1.2
    with pytest.raises(PmmkitError, match="knows neither groups"):
        sparse_regression(ship, measured(), "Yv Yr", method="elimination", groups=[["Yv", "Yr"]])


@pytest.mark.slow
def test_noisy_forces_give_the_terms_with_intervals_that_hold_the_truth(found):
    assert set(found.table.names) == set(TRUTH)
    assert all(found.share[name] >= 0.95 for name in TRUTH)
    assert found.table.at() == pytest.approx(TRUTH, rel=0.03)
    assert np.all(found.table.std < 0.03)
    low, high = found.table.interval(0.999)
    right = np.array([TRUTH[name] for name in found.table.names])
    assert np.sum((low[0] <= right) & (right <= high[0])) >= 7
    errors = [x for own in found.held_out.values() for x in own.values()]
    assert len(found.held_out) == 18
    assert min(errors) > 0.85
    assert max(errors) < 1.2


@pytest.mark.slow
@pytest.mark.parametrize("seed", [4, 5])
def test_terms_that_are_not_there_are_left_out_of_nine_bags_in_ten(ship, seed):
    result = sparse_regression(
        ship, measured(seed=seed), LIBRARY + " Yvvv Nvvv Yrrr Nrrr", bags=50, seed=seed
    )
    absent = [name for name in result.names if name not in TRUTH]
    assert len(absent) == 8
    assert all(result.share[name] <= 0.1 for name in absent)
    assert set(result.left_out) == set(absent)
    assert not set(absent) & set(result.model.parts["hull_polynomial"].values)


@pytest.mark.slow
def test_the_std_is_the_scatter_between_campaigns(ship):
    """Offsets of runs make a regression on samples too narrow; the design effect knows of them."""
    results = [
        sparse_regression(
            ship, measured(seed=seed), " ".join(TRUTH), threshold=0.0, bags=60, method="stepwise"
        )
        for seed in range(24)
    ]
    scatter = np.std([x.table.value[0] for x in results], axis=0, ddof=1)
    stated = np.sqrt(np.mean([x.table.std[0] ** 2 for x in results], axis=0))
    ratio = stated / scatter
    assert 0.85 < np.exp(np.mean(np.log(ratio))) < 1.5
    assert np.all((ratio > 0.6) & (ratio < 2.2))


@pytest.mark.slow
def test_the_model_found_gives_the_forces_and_is_simulated(ship, found):
    ready = prepare(found.model, 1.2)
    motion = captive()["yaw 0.1 drift 8"]
    force = ready.water_forces(motion)
    for channel, values in by_hand(motion).items():
        assert np.max(np.abs(force[channel] - values)) < 0.01 * np.max(np.abs(values))
    exact = ship.with_values("hull_polynomial", **TRUTH)
    turns = [
        simulate(model, "turning", rudder_deg=35, speed=1.2, compiled=False).metrics[
            "tactical_diameter_L"
        ]
        for model in (exact, found.model)
    ]
    assert turns[1] == pytest.approx(turns[0], rel=0.01)
    assert found.model.covariance_names == found.table.names
    part = found.model.parts["hull_polynomial"]
    assert part.source_of("Yv") == "measured: sparse regression of forces"
    assert part.source_of("Xuu").startswith("library")


def test_columns_are_those_of_the_hull_polynomial(ship):
    names = LIBRARY.split()
    record = measured()[-1]
    rows = equations(ship, [record], names, ("Y", "N"))[0].channels
    state = State.of(u=record.motion["u"], v=record.motion["v"], r=record.motion["r"])
    columns = Regressors.at(
        names,
        state,
        ship=ship.ship,
        water=ship.water,
        convention=ship.convention,
        approach_speed=1.2,
    ).columns
    for channel in ("Y", "N"):
        own = np.array([name[0] == channel for name in names])
        design = rows[channel][0] * record.std[channel]
        size = np.abs(columns[:, own]).max()
        np.testing.assert_allclose(design[:, own], columns[:, own], rtol=0, atol=1e-11 * size)
        assert not design[:, ~own].any()


def test_an_added_mass_with_coriolis_terms_counts_in_every_channel(ship):
    """Separate Coriolis terms: my stands in Y beside v' and in X beside v r."""
    model = load_model("kvlcc2-l7")
    ready = prepare(model, 1.2)
    motions = captive()
    records = [
        ForceRecord(
            name=name, motion=m, forces=ready.water_forces(m), std={"X": 0.01, "Y": 0.01}, speed=1.2
        )
        for name, m in motions.items()
    ]
    start = model.with_values("added_mass", Yvdot=-0.1)
    result = sparse_regression(
        start, records, "Yvdot Xvr Yv", bags=5, threshold=1.0, method="stepwise"
    )
    assert result.table.at() == pytest.approx({"Yvdot": -0.223, "Xvr": 0.002, "Yv": -0.315})
    assert result.model.parts["added_mass"].values["Yvdot"] == pytest.approx(-0.223)


def test_terms_that_move_together_are_named_before_the_fit(ship):
    report = look_for_collinearity(ship, measured(), "Yv Yv|v| Yvvv Yr")
    assert report.pairs[0][:2] == ("Yv|v|", "Yvvv")
    v = np.concatenate([m["v"] for m in captive().values()])
    U = np.concatenate([np.hypot(m["u"], m["v"]) for m in captive().values()])
    a, b = v * np.abs(v), v**3 / U
    cosine = a @ b / np.sqrt((a @ a) * (b @ b))
    assert report.pairs[0][2] == pytest.approx(cosine, abs=1e-9)
    assert report.inflation["Yv|v|"] > 100
    assert report.inflation["Yr"] < 2
    assert report.condition["Y"] > 30
    assert "Yv|v| and Yvvv move together" in report.warnings[0]
    assert f"cosine {cosine:.3f}" in report.warnings[0]
    assert "condition number" in report.warnings[-1]
    assert look_for_collinearity(ship, measured(), "Yv Yr Nv Nr").warnings == ()


def test_collinearity_stands_among_the_warnings_of_a_fit(ship):
    result = sparse_regression(
        ship, measured(), "Yv Yr Yv|v| Yvvv Yvrr", bags=5, threshold=1.0, method="stepwise"
    )
    assert any("Yv|v| and Yvvv move together" in text for text in result.warnings)
    assert any("Held at the model's values" in text and "Yvdot" in text for text in result.warnings)


@pytest.mark.slow
def test_the_weak_form_averages_the_noise_of_measured_motions(ship):
    """Noise in v and r pulls the coefficients of the strong form; the weak one takes it out."""
    error = {}
    for weak in (False, 20):
        wrong = []
        for seed in range(4):
            records = measured(noise=4.0, moved=0.05, seed=seed)
            result = sparse_regression(
                ship, records, " ".join(TRUTH), bags=2, threshold=0.0, method="stepwise", weak=weak
            )
            at = result.table.at()
            wrong += [at[name] / value - 1 for name, value in TRUTH.items()]
        error[weak] = np.sqrt(np.mean(np.square(wrong)))
    assert error[20] < 0.12
    assert error[False] > 0.4


@pytest.mark.slow
def test_the_weak_form_keeps_exact_equations_exact_and_white_noise_white(ship):
    exact = sparse_regression(
        ship, measured(noise=0.0), LIBRARY, bags=5, weak=True, method="stepwise"
    )
    assert exact.table.at() == pytest.approx(TRUTH, rel=1e-9)
    noise = np.random.default_rng(0).normal(size=(20_000, 1))
    assert np.std(averaged(noise, 25)) == pytest.approx(1.0, abs=0.05)
    gap = np.ones((100, 1))
    gap[50] = np.nan
    assert np.isnan(averaged(gap, 11)).sum() in (1, 2, 3)
    assert averaged(np.ones((1, 2)), 20).shape == (1, 2)


@pytest.mark.slow
def test_fixed_terms_stay_as_they_are_and_their_force_counts_as_known(ship):
    known = ship.with_values("hull_polynomial", Yv=-0.30, Nr=-0.05)
    result = sparse_regression(
        known, measured(noise=0.0), LIBRARY, fixed=["Yv", "Nr"], bags=5, method="stepwise"
    )
    assert not {"Yv", "Nr"} & set(result.names)
    assert {"Yv", "Nr"} <= set(result.held)
    assert result.table.at() == pytest.approx(
        {name: value for name, value in TRUTH.items() if name not in ("Yv", "Nr")}, rel=1e-9
    )
    hull = result.model.parts["hull_polynomial"]
    assert hull.values["Yv"] == -0.30
    assert hull.source_of("Yv").startswith("library")


def test_a_group_enters_or_leaves_as_one(ship):
    groups = {"drag": ["Yv|v|", "Yr|r|", "Nv|v|", "Nr|r|"], "cross": ["Yvrr", "Nvrr"]}
    result = sparse_regression(ship, measured(noise=8.0), LIBRARY, groups=groups, bags=40)
    assert [path.channels for path in result.paths] == [("Y", "N")]
    for members in groups.values():
        columns = [result.names.index(name) for name in members]
        inside = result.coefficients[:, columns] != 0
        assert np.all(inside == inside[:, :1])
        assert len({result.share[name] for name in members}) == 1
        assert len({name in result.table for name in members}) == 1
    assert result.share["Yr|r|"] == result.share["Yv|v|"] == 1.0
    assert result.share["Yvvr"] < 0.1


def test_groups_by_physics_cover_the_library():
    names = [*LIBRARY.split(), "Xvr", "Xvv", "Yphi", "Yvdot", "Yd", "N0", "Kp|p|", "Yvvphi"]
    groups = physics_groups(names)
    assert sorted(name for group in groups.values() for name in group) == sorted(names)
    assert groups["cubic"] == ("Yvvr", "Yvrr", "Nvvr", "Nvrr")
    assert groups["roll"] == ("Yphi", "Kp|p|", "Yvvphi")


def test_terms_that_always_stay_do(ship):
    result = sparse_regression(
        ship, measured(), LIBRARY, always=["Nvrr"], threshold=1e4, bags=5, method="stlsq"
    )
    assert "Nvrr" in result.table
    assert result.share["Nvrr"] == 1.0
    assert len(result.table.names) < 5


@pytest.mark.slow
def test_the_same_seed_gives_the_same_result(ship):
    def ask(seed):
        return sparse_regression(ship, measured(), LIBRARY, seed=seed, bags=8, method="stepwise")

    state = np.random.get_state()[1].copy()  # noqa: NPY002
    first, again, other = ask(1), ask(1), ask(2)
    np.testing.assert_array_equal(first.coefficients, again.coefficients)
    np.testing.assert_array_equal(first.table.value, again.table.value)
    assert first.warnings == again.warnings
    assert not np.array_equal(first.coefficients, other.coefficients)
    np.testing.assert_array_equal(np.random.get_state()[1], state)  # noqa: NPY002


def test_plain_pysindy_agrees_where_it_can_do_the_whole_task(ship):
    """One channel, one noise, nothing known, unit speed: SINDy with a library of its own."""
    import pysindy

    v = np.linspace(-0.5, 0.5, 400)
    u = np.sqrt(1 - v**2)
    rng = np.random.default_rng(2)
    still = {name: np.zeros(400) for name in ("r", "vdot", "rdot")}
    unit = 0.5 * RHO * L * D
    motion = {"u": u, "v": v, "n": np.full(400, 1.7)}
    empty = by_hand(motion | still, {})["Y"]
    Y = by_hand(motion | still, {"Yv": -0.3, "Yvvv": -1.6})["Y"] + 2.0 * rng.normal(size=400)
    parts = np.array_split(rng.permutation(400), 5)
    records = [
        ForceRecord(
            name=str(i),
            motion={key: x[own] for key, x in motion.items()},
            forces={"Y": Y[own]},
            std={"Y": 2.0},
            speed=1.0,
        )
        for i, own in enumerate(parts)
    ]
    ours = sparse_regression(ship, records, "Yv Yvvv Yvvvvv", threshold=5.0, bags=10)
    library = pysindy.CustomLibrary(
        [lambda x: x, lambda x: x**3, lambda x: x**5], interaction_only=False
    )
    theirs = pysindy.SINDy(
        optimizer=pysindy.STLSQ(threshold=0.25, alpha=1e-12), feature_library=library
    ).fit(v[:, None], t=1.0, x_dot=((Y - empty) / unit)[:, None])
    assert ours.table.names == ("Yv", "Yvvv")
    assert theirs.coefficients()[0] == pytest.approx([*ours.table.value[0], 0.0], rel=1e-6)


@pytest.mark.slow
def test_another_optimizer_of_pysindy_serves_bag_by_bag(ship):
    from pysindy import FROLS, STLSQ

    rule = STLSQ(threshold=1.0, alpha=0.0)
    result = sparse_regression(ship, measured(), LIBRARY, method=rule, bags=8)
    same = sparse_regression(ship, measured(), LIBRARY, threshold=1.0, bags=8)
    assert result.paths == ()
    assert result.table.names == same.table.names
    np.testing.assert_allclose(result.coefficients, same.coefficients, rtol=1e-9)
    greedy = sparse_regression(ship, measured(), "Yv Yr Yv|v|", method=FROLS(alpha=0.0), bags=4)
    assert greedy.share["Yv"] == greedy.share["Yr"] == 1.0
    with pytest.raises(PmmkitError, match="knows neither groups"):
        sparse_regression(ship, measured(), "Yv Yr", method=rule, always=["Yv"])


def test_what_no_run_excites_keeps_the_values_of_the_model(ship):
    drifts = [record for record in measured() if record.name.startswith("drift")]
    known = ship.with_values("hull_polynomial", Yr=0.07)
    result = sparse_regression(
        known, drifts, "Xvr Yv Yr Yv|v|", bags=20, threshold=1.0, method="stepwise"
    )
    assert result.undetermined == ("Yr",)
    assert result.model.parts["hull_polynomial"].values["Yr"] == 0.07
    assert any("No run excites Yr" in text for text in result.warnings)
    assert any("Not looked for" in text and "Xvr" in text for text in result.warnings)
    assert any("rough" in text for text in result.warnings)


def test_a_term_that_rests_on_one_run_is_judged_by_the_bags_that_hold_it(ship):
    """Bags without the only yaw run say nothing of Yr: they do not count against it."""
    records = [r for r in measured() if r.name.startswith(("drift", "sway"))]
    records += [r for r in measured() if r.name == "yaw 0.1"]
    result = sparse_regression(
        ship, records, "Yv Yr Yv|v|", bags=60, threshold=1.0, method="stepwise"
    )
    own = result.coefficients[:, result.names.index("Yr")]
    assert 0.2 < np.mean(np.isnan(own)) < 0.5
    assert result.share["Yr"] == 1.0
    assert any("Yr rests on 1 of 10 runs" in text for text in result.warnings)


@pytest.mark.slow
def test_gaps_do_not_count(ship):
    records = []
    for record in measured(noise=0.0):
        Y = record.forces["Y"].copy()
        Y[::7] = np.nan
        records.append(replace(record, forces=dict(record.forces) | {"Y": Y}))
    result = sparse_regression(ship, records, LIBRARY, bags=5, method="stepwise")
    assert result.table.at() == pytest.approx(TRUTH, rel=1e-9)


def one_angle():
    return [replace(r, name=f"{r.name} {i}") for i in range(4) for r in measured()[:1]]


REFUSED = [
    (lambda r: r[:2], LIBRARY, {}, "too few"),
    (lambda r: [*r, r[0]], LIBRARY, {}, "named drift -16"),
    (lambda r: r, "", {}, "empty"),
    (lambda r: r, "Yv Zv", {}, "Zv"),
    (lambda r: r, "Xvv Kv", {}, "Nothing to look for"),
    (lambda r: r, "Yv", {"fixed": ["Yv"]}, "no value of Yv"),
    (lambda r: r, "Yvdot", {"fixed": ["Yvdot"]}, "no free terms"),
    (lambda r: r, "Yp Yv", {}, "roll"),
    (lambda r: r, "Yvvvdot Yv", {}, "no place for"),
    (lambda r: r, "Yv Yr", {"groups": [["Yv", "Nv"]]}, "Nv of groups"),
    (lambda r: r, "Yv Yr", {"groups": [["Yv", "Yr"], ["Yv"]]}, "two groups"),
    (lambda r: r, "Yv Yr", {"groups": "chemistry"}, "physics"),
    (lambda r: r, "Yv Yr", {"always": ["Nv"]}, "Nv of always"),
    (lambda r: r, LIBRARY, {"bags": 0, "share": 2.0, "threshold": -1.0, "weak": 0}, "4 problems"),
    (lambda r: r, "Yv Yr", {"threshold": 1e6}, "No term stays"),
    (lambda r: [replace(x, std={}) for x in r], LIBRARY, {}, "no channel"),
    (lambda r: [replace(x, std={"Y": 0.0}) for x in r], LIBRARY, {}, "must be positive"),
    (lambda r: [replace(x, motion={"u": np.ones(3)}) for x in r], LIBRARY, {}, "same number"),
    (lambda r: [replace(x, motion={}, forces={}) for x in r], LIBRARY, {}, "at least one"),
    (lambda r: [replace(x, speed=0.0) for x in r], LIBRARY, {}, "must be positive"),
    (lambda r: r[:6], "Yr Nr", {}, "No run excites Yr, Nr"),
    (lambda r: one_angle(), "Yv Yvvv", {}, "cannot tell Yv, Yvvv apart"),
    (
        lambda r: [replace(x, forces={"Y": np.full(300, np.nan)}) for x in r],
        LIBRARY,
        {},
        "finite forces",
    ),
]


@pytest.mark.slow
@pytest.mark.parametrize(("records", "library", "choices", "said"), REFUSED)
def test_what_cannot_be_done_is_refused_with_what_to_do(ship, records, library, choices, said):
    with pytest.raises(PmmkitError, match=said):
        sparse_regression(ship, records(measured()), library, **choices)


@pytest.mark.slow
def test_importing_does_not_load_pysindy():
    code = "import sys, pmmkit.identification.sparse.regression\nprint(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not {"pysindy", "sklearn", "pandas", "scipy.stats"} & set(done.stdout.split())
