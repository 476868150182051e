"""Diagnosis of free-running records: nothing hidden, something hidden, and what cannot be told."""

from __future__ import annotations

import csv
import math

import numpy as np
import pytest

import pmmkit as pk
from pmmkit import FreeRecord
from pmmkit.base import DataError
from pmmkit.diagnosis import undone
from pmmkit.diagnosis.free_running.base import FreeBase, base_of, stated_base
from pmmkit.diagnosis.free_running.diagnose import diagnose_free
from pmmkit.diagnosis.free_running.fits import place_at
from pmmkit.diagnosis.free_running.hypotheses import Numbers, candidates_for, weighed
from pmmkit.diagnosis.free_running.information import Forces, WindowInformation
from pmmkit.diagnosis.free_running.question import PACE, paced, question_of
from pmmkit.diagnosis.free_running.slopes import sheets_of
from pmmkit.effects import OUTSIDE
from pmmkit.identification import Prior
from pmmkit.models import model_text
from tests.support.zigzags import ASYMMETRY, KNOWN, RUNS, SENSORS, SHIP, SPEED, sailed

PRIME = SHIP.ship.d / SHIP.ship.L
"""Of coefficients over ½ρL²U², as findings have them, to those of the ship over ½ρLdU²."""
YAW_DRAG = SHIP.with_values("hull_polynomial", **{"Yr|r|": 0.10, "Nr|r|": -0.076})


def asked(
    seed,
    model=SHIP,
    *,
    few=("asymmetry", "fault_rudder_zero", "modulus_yaw_drag"),
    zero=0.0,
    **settings,
):
    """The diagnosis of a ship whose captive tests are off by 2 % in every value."""
    prior = Prior.of(SHIP, KNOWN, SPEED, spread=0.02)
    values = prior.mean + prior.std * np.random.default_rng(1000 + seed).normal(size=len(KNOWN))
    hull = dict(zip(KNOWN[:-1], values[:-1].tolist(), strict=True))
    known = SHIP.with_values("hull_polynomial", **hull)
    records = sailed(model, seed, zero=zero)
    some = [item for item in candidates_for(known, records) if item.name in few]
    return diagnose_free(
        known,
        records,
        prior=Prior.of(known, KNOWN, SPEED, spread=0.02),
        candidates=some,
        sensors=SENSORS,
        most=1,
        **settings,
    )


@pytest.fixture(scope="module")
def asymmetric():
    return asked(0, ASYMMETRY, held_out=sailed(ASYMMETRY, 7, runs=((-20.0, 20.0),)))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
def test_nothing_is_named_where_nothing_is_hidden(seed):
    """Captive tests are off by 2 %, which records tell: no effect is missing, values are others."""
    found = asked(seed)
    assert found.verdict == "refit"
    assert found.group == ()
    assert found.findings == ()
    assert found.entries[0].log_evidence < 0.0


@pytest.mark.slow
def test_an_asymmetry_is_named_and_the_error_falls(asymmetric):
    assert asymmetric.verdict == "missing_effect"
    assert asymmetric.group[0] == (("asymmetry",), 1.0)
    assert all(names in (("asymmetry",), ("fault_rudder_zero",)) for names, _ in asymmetric.group)
    (finding,) = asymmetric.findings
    assert finding.family == "asymmetry"
    assert asymmetric.chance < 0.01
    for name, true in (("Y0", 0.0022), ("N0", -0.001)):
        assert abs(finding.coefficients[name] - true * PRIME) < 3.5 * finding.std[name]
    assert finding.error_after < 0.7 * finding.error_before
    assert finding.to_dict()["errors"]["heading"]["unit"] == "deg"
    before = asymmetric.errors["held out, base refitted"]
    after = asymmetric.errors["held out, with the effects"]
    assert after["heading"] < 0.6 * before["heading"]
    assert after["yaw_rate"] < 0.6 * before["yaw_rate"]


@pytest.mark.slow
def test_the_model_carries_the_effect(asymmetric):
    values = asymmetric.model.parts["hull_polynomial"].values
    assert values["N0"] == pytest.approx(asymmetric.findings[0].coefficients["N0"] / PRIME)
    assert "N0" not in asymmetric.refitted.parts["hull_polynomial"].values
    C = dict(
        zip(asymmetric.model.covariance_names, asymmetric.model.covariance.diagonal(), strict=True)
    )
    assert math.sqrt(C["N0"]) == pytest.approx(asymmetric.findings[0].std["N0"] / PRIME)


@pytest.mark.slow
def test_a_finding_enters_the_model_beside_what_it_has(asymmetric):
    """What is found comes to the values that were known, and is taken out again to the bit."""
    known = SHIP.with_values("hull_polynomial", Y0=0.001)
    better = pk.with_effect(known, asymmetric.findings[0])
    found = asymmetric.findings[0].coefficients
    values = better.values("hull_polynomial")
    assert values["Y0"] == pytest.approx(0.001 + found["Y0"] / PRIME)
    assert values["N0"] == pytest.approx(found["N0"] / PRIME)
    back, name = undone(better)
    assert name == "asymmetry"
    assert model_text(back) == model_text(known)


@pytest.mark.slow
def test_a_rudder_zero_is_told_from_an_asymmetry():
    """Both push the ship to one side, but a rudder does so as its slipstream changes."""
    found = asked(0, zero=math.radians(1.5))
    assert found.group[0][0] == ("fault_rudder_zero",)
    assert found.corrections["rudder_zero"] == pytest.approx(math.radians(1.5), rel=0.1)


@pytest.mark.slow
def test_a_hull_term_is_named_against_an_asymmetry():
    found = asked(1, YAW_DRAG)
    assert found.group == ((("modulus_yaw_drag",), 1.0),)
    assert found.findings[0].coefficients["Nr|r|"] == pytest.approx(-0.076 * PRIME, rel=0.3)


@pytest.mark.slow
def test_what_no_candidate_explains_is_not_named():
    """A yaw drag with only asymmetries to choose from."""
    found = asked(0, YAW_DRAG, few=("asymmetry", "fault_rudder_zero"))
    assert found.verdict == "unexplained"
    assert found.findings == ()


def asked_of(records, names=KNOWN, candidates=(), **settings):
    base = stated_base(Prior.of(SHIP, names, SPEED, spread=0.02))
    how = {"floor": 0.001, "window": None, "sensors": SENSORS, "extrapolate": False}
    return question_of(SHIP, records, candidates, base, tell=lambda _: None, **how | settings)


def test_what_the_true_model_leaves_is_the_noise_of_the_sensors():
    """The sum of squares over the averages left after the starts is chi-square: 1 a piece."""
    question = asked_of(sailed(SHIP, 3))
    place = place_at(question, np.zeros(len(KNOWN)))
    rows = sum(len(x.errors) - x.starts.shape[1] for own in place.sheets for x in own)
    calm = Forces(shares=np.full(3, 1e-9), memory=1.0)
    left = place.information.under(calm).normal.square
    assert left / rows == pytest.approx(1.0, abs=4.0 * math.sqrt(2.0 / rows))


def test_noise_is_told_from_the_records():
    """Nobody stated it: third differences first, then what starts and forces leave."""
    question = asked_of(sailed(SHIP, 3), sensors={})
    for name, std in SENSORS.items():
        assert question.sensors[name] == pytest.approx(std, rel=0.15), name


def test_an_outlier_is_left_out():
    records = sailed(SHIP, 3)
    wild = records[0].measured["psi"].copy()
    wild[60] += 0.5
    spoiled = records[0].with_(measured={**records[0].measured, "psi": wild})
    question = asked_of([spoiled, *records[1:]])
    assert question.outliers == 1
    assert np.isnan(question.stretches[0].record.measured["psi"][60])


@pytest.mark.parametrize("step", [0.01, 0.02, 0.05, 0.09, 0.2])
def test_an_average_stands_at_its_instant(step):
    """However finely a straight line is sampled, its averages lie on it."""
    t = np.arange(0.0, 20.0, step)
    record = FreeRecord(name="line", t=t, delta=t, turns=t, measured={"psi": 0.1 * t}, speed=SPEED)
    thin, count = paced(record, SHIP.ship.L)
    assert np.median(np.diff(thin.t)) == pytest.approx(count * step)
    assert thin.measured["psi"] == pytest.approx(0.1 * thin.t)
    assert np.median(np.diff(thin.t)) <= max(2.0 * PACE * SHIP.ship.L / SPEED, step)


def test_slopes_are_those_of_a_small_step():
    question = asked_of(sailed(SHIP, 4))
    z = 0.1 * np.random.default_rng(0).normal(size=len(KNOWN))
    here = place_at(question, np.zeros(len(KNOWN)))
    there = question.sheets(z, question.numbers.every)
    change = question.numbers.T @ z
    for own, moved in zip(here.sheets, there, strict=True):
        for sheet, other in zip(own, moved, strict=True):
            step = sheet.errors - other.errors
            off = np.linalg.norm(step - sheet.values @ change)
            assert off < 0.02 * np.linalg.norm(step)


def test_slopes_over_each_value_are_those_of_two_ships_a_little_apart():
    """Hull, mass, rudder, propeller, current and instruments, one by one, through whole windows."""
    records = sailed(SHIP, 4, runs=((20.0, 10.0),))
    few = {
        "asymmetry",
        "current",
        "fault_rudder_zero",
        "fault_clock_lag",
        "fault_log_gain",
        "rudder_hull_interaction",
        "acceleration_cross_terms",
    }
    some = [item for item in candidates_for(SHIP, records) if item.name in few]
    question = asked_of([*records, *records], candidates=some)
    assert len(question.numbers.every) > len(KNOWN) + len(few)
    numbers = question.numbers
    still = np.zeros(len(numbers.every))
    sheets = question.sheets(still, numbers.every)
    for j in numbers.every:
        step = 1e-3 * np.eye(len(still))[j]
        less, more = (question.sheets(sign * step, still[:0].astype(int)) for sign in (-1.0, 1.0))
        change = numbers.T @ step
        for own, low, high in zip(sheets, less, more, strict=True):
            expected = np.concatenate([a.errors - b.errors for a, b in zip(low, high, strict=True)])
            found = np.concatenate([2.0 * sheet.values @ change for sheet in own])
            assert np.linalg.norm(found - expected) < 5e-3 * np.linalg.norm(expected), j


def test_slopes_over_start_and_forces_are_those_of_the_equations():
    """A start a little off, and a constant force on all of a window, sailed whole."""
    question = asked_of(sailed(SHIP, 4))
    still = np.zeros(len(KNOWN))
    (stretch, *_) = question.stretches
    sheets = sheets_of(stretch, still)
    for state, step in (("r", 1e-4), ("u", 1e-3), ("psi", 1e-3)):
        starts = stretch.starts.copy()
        starts[:, stretch.states.index(state)] += step
        moved = sheets_of(stretch.along(starts, stretch.forces), still)
        for sheet, other in zip(sheets, moved, strict=True):
            slope = sheet.starts[:, stretch.states.index(state)]
            off = np.linalg.norm(slope * step - (sheet.errors - other.errors))
            assert off < 0.01 * np.linalg.norm(slope * step)
    push = 1e-4
    more = stretch.forces + push * np.array([0.0, 1.0, 0.0])
    pushed = stretch.along(stretch.starts, more)
    for sheet, other in zip(sheets, sheets_of(pushed, still), strict=True):
        slope = sheet.forces[:, :, 1].sum(axis=1)
        off = np.linalg.norm(slope * push - (sheet.errors - other.errors))
        assert off < 0.01 * np.linalg.norm(slope * push)


def test_unknown_forces_are_those_of_their_covariance():
    forces = Forces(shares=np.array([0.1, 0.2, 0.3]), memory=1.5)
    (root,) = forces.root(np.array([0.4]), 6)
    apart = 0.4 * np.abs(np.arange(6)[:, None] - np.arange(6))
    expected = np.kron(np.exp(-apart / 1.5), np.diag(forces.shares**2))
    assert root @ root.T == pytest.approx(expected, abs=1e-12)


def test_evidence_is_that_of_a_normal_law():
    """Against the density of e ~ N(0, V + G Λ Gᵀ), written out for a handful of numbers."""
    rng = np.random.default_rng(1)
    base = FreeBase(
        names=("a", "b"),
        sizes=np.ones(2),
        known=np.zeros((2, 2)),
        spreads=np.array([0.5]),
        open=np.ones(2, bool),
        alone=np.zeros(2, bool),
    )
    numbers = Numbers(
        values=("a", "b", "c", "d"),
        T=np.eye(4),
        base=base,
        columns={"first": np.array([2]), "second": np.array([3])},
    )
    G, e = rng.normal(size=(9, 4)), rng.normal(size=9)
    wide = np.column_stack([G, e])
    known = WindowInformation(
        products=(wide.T @ wide)[None], volumes=np.zeros(1), owners=np.zeros(1, int)
    )
    found = weighed(known, numbers)
    for names, columns in ((), []), (("first",), [2]), (("second", "first"), [2, 3]):
        V = np.eye(9) + 0.25 * G[:, :2] @ G[:, :2].T + G[:, columns] @ G[:, columns].T
        truth = -0.5 * e @ np.linalg.solve(V, e) - 0.5 * np.linalg.slogdet(V)[1]
        assert found(names) == pytest.approx(truth)


def test_terms_are_carried_to_the_system_of_the_model():
    """A coefficient is one of ½ρL²U²: it moves a value over ½ρLdU² by L/d as much."""
    prime = {x.name: x for x in candidates_for(pk.load_model("s175-3dof"), [])}
    tanker = {x.name: x for x in candidates_for(SHIP, [])}
    ratio = SHIP.ship.L / SHIP.ship.d
    for name in ("asymmetry", "modulus_yaw_drag"):
        for label, size in prime[name].typical.items():
            assert tanker[name].typical[label] == size
            assert prime[name].moves[label] == {label: pytest.approx(1.0)}
            assert tanker[name].moves[label] == {label: pytest.approx(ratio)}


def test_candidates_have_a_place_in_the_model():
    for ship in ("kvlcc2-l7", "s175-3dof", "esso-osaka-3m"):
        model = pk.load_model(ship)
        every = candidates_for(model, [])
        assert len({item.name for item in every}) == len(every)
        for item in every:
            assert set(item.typical) == set(item.moves)
            assert all(size != 0.0 for size in item.typical.values())
            base = [x for x in item.values if x not in OUTSIDE]
            if base:
                Prior.of(item.added_to(model), base, model.ship.speed(0.14, 9.81), spread=0.1)


@pytest.mark.slow
def test_one_record_is_not_enough():
    records = sailed(SHIP, 0, runs=RUNS[:1])
    with pytest.raises(DataError, match="at least two"):
        diagnose_free(
            SHIP,
            records,
            prior=Prior.of(SHIP, KNOWN, SPEED, spread=0.02),
            candidates=[],
            sensors=SENSORS,
        )


def container(shared_data):
    """The trajectories of an independent program (S175 with roll)."""
    folder = shared_data / "s175_container_m"
    if not folder.is_dir():
        pytest.skip("s175_container_m is not on this machine")
    found = []
    for path in sorted(folder.glob("*U6*.csv")):
        with path.open() as file:
            rows = list(csv.DictReader(file))
        column = {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}
        measured = {name: column[name] for name in ("x", "y", "psi", "u", "v", "r", "p", "phi")}
        record = FreeRecord(
            name=path.stem,
            t=column["t"],
            delta=column["delta"],
            turns=column["n_rpm"] / 60.0,
            measured=measured,
            speed=6.0,
        )
        found.append(record.cut(0.0, 500.0))
    return found


FAST = {"x": 1.0, "y": 1.0, "psi": 2e-3, "u": 0.03, "v": 0.03, "r": 2e-4, "p": 2e-4, "phi": 2e-3}


@pytest.mark.slow
@pytest.mark.parametrize("hidden", [(), ("Nvvr", "Nvrr", "Yvvr", "Yvrr")])
def test_an_independent_ship(shared_data, hidden):
    """Trajectories that pmmkit did not make: with the full model nothing, else the coupling."""
    records = container(shared_data)
    full = pk.load_model("s175")
    model = full.with_values("hull_polynomial", **dict.fromkeys(hidden, 0.0))
    names = ("Xuu", "Yv", "Yr", "Nv", "Nr")
    few = ("yaw_sway_coupling", "asymmetry", "surge_quadratic")
    found = diagnose_free(
        model,
        records,
        prior=Prior.of(model, names, 6.0, spread=0.03),
        sensors=FAST,
        most=1,
        candidates=[x for x in candidates_for(model, records) if x.name in few],
    )
    if hidden:
        assert found.group[0][0] == ("yaw_sway_coupling",)
        assert found.findings[0].family == "hull coupling"
    else:
        assert found.verdict == "noise"


def test_the_base_holds_the_covariance_and_weighs_spreads():
    std = np.array([0.01, 0.02])
    known = SHIP.with_(covariance=np.diag(std**2), covariance_names=("Yv", "Nv"))
    found = base_of(known, SPEED, spread=0.1)
    i = found.names.index("Nv")
    assert found.known[i, i] * found.sizes[i] ** 2 == pytest.approx(std[1] ** 2)
    assert found.spreads[0] == 0.0
    assert found.spreads[-1] == 0.1


def test_a_value_that_is_too_small_moves_by_its_usual_size():
    """The spread is a share of what is usual: a start value of nearly zero must not hold it."""
    tiny = SHIP.with_values("hull_polynomial", Nvvr=-1e-6)
    found = base_of(tiny, SPEED)
    assert found.sizes[found.names.index("Nvvr")] == pytest.approx(0.0424 / PRIME, rel=1e-3)
