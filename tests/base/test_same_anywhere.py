"""All that takes ``executor=`` gives the same to the bit with it as without."""

from __future__ import annotations

import json
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import pmmkit as pk
from pmmkit import froude_sweep, sweep
from pmmkit.base import DataError
from pmmkit.cli import main
from pmmkit.diagnosis.free_running.diagnose import diagnose_free
from pmmkit.diagnosis.free_running.hypotheses import candidates_for
from pmmkit.effects import CATALOGUE
from pmmkit.identification import Prior
from pmmkit.intake import examine
from pmmkit.reduction import View
from pmmkit.simulation import sensitivities, sobol
from scripts.datasets.make_large import make
from tests.support.zigzags import ASYMMETRY, KNOWN, SENSORS, SHIP, SPEED, sailed

TURN = {"rudder_deg": 35, "speed": 7.97, "spread": 0.05}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("campaign")
    make(place, runs=20, mb=0.02)
    return place


@pytest.fixture
def threads():
    """Any executor of `concurrent.futures`."""
    with ThreadPoolExecutor(2) as executor:
        yield executor


def words(found):
    return json.dumps(found.to_dict(), default=repr)


@pytest.mark.slow
@pytest.mark.parametrize("n", [1, 2500, 6001])
def test_drawn_ships(threads, n):
    told = []
    here = pk.monte_carlo("kvlcc2", n=n, seed=3, **TURN)
    there = pk.monte_carlo(
        "kvlcc2", n=n, seed=3, executor=threads, progress=lambda *x: told.append(x[:2]), **TURN
    )
    assert told[-1] == (n, n)
    assert here.failed == there.failed
    for name, values in here.metrics.items():
        assert values.tobytes() == there.metrics[name].tobytes()


@pytest.mark.slow
def test_sensitivities_and_sobol_indices(threads):
    slopes = [sensitivities("s175-3dof", executor=who, **TURN).slopes for who in (None, threads)]
    shares = [sobol("s175-3dof", n=64, executor=who, **TURN).total for who in (1, threads)]
    for here, there in (slopes, shares):
        assert all(values.tobytes() == there[name].tobytes() for name, values in here.items())


@pytest.mark.slow
def test_sweeps(threads):
    for found in (
        lambda who: froude_sweep("s175-3dof", [6.0, 9.0], n=50, spread=0.05, executor=who),
        lambda who: sweep("kvlcc2", "rudder_deg", [10, 20, 35], speed=7.97, executor=who),
    ):
        assert found(threads).identical(found(None))


@pytest.mark.slow
def test_what_checks_and_diagnosis_see_of_captive_tests(folder, threads):
    campaign = pk.open_campaign(folder)
    campaign = campaign.with_(runs=campaign.runs[::5])

    def seen(who):
        views = View.of(campaign, executor=who)
        arrays = [x for view in views for x in (view.projection, *view.force.values())]
        told = [str(finding) for finding in examine(campaign, executor=who)]
        return [x.tobytes() for x in arrays], [view.run for view in views], told

    assert seen(threads) == seen(2) == seen(None)


@pytest.mark.slow
def test_a_diagnosis_of_captive_tests(folder, threads):
    few = [CATALOGUE["modulus_sway_drag"], CATALOGUE["asymmetry"]]
    here, there = (
        pk.diagnose("linear", pk.open_campaign(folder), candidates=few, executor=who)
        for who in (None, threads)
    )
    assert words(here) == words(there)


@pytest.mark.slow
def test_a_diagnosis_of_records(threads):
    records = sailed(ASYMMETRY, 0)
    few = ("asymmetry", "modulus_yaw_drag")
    found = [
        diagnose_free(
            SHIP,
            records,
            prior=Prior.of(SHIP, KNOWN, SPEED, spread=0.02),
            candidates=[x for x in candidates_for(SHIP, records) if x.name in few],
            sensors=SENSORS,
            most=1,
            executor=who,
        )
        for who in (None, threads)
    ]
    assert words(found[0]) == words(found[1])
    assert found[0].group == ((("asymmetry",), 1.0),)
    assert np.array_equal(*(list(x.model.parts["hull_polynomial"].values.values()) for x in found))


def test_workers_or_a_scheduler_are_an_option_of_commands(folder, tmp_path, monkeypatch, capsys):
    asked = []

    def reduce_campaign(campaign, **how):
        asked.append(how["executor"])
        raise DataError("enough")

    monkeypatch.setattr("pmmkit.reduction.reduce_campaign", reduce_campaign)
    command = ["reduce", str(folder), "--out", str(tmp_path)]
    for how in ([], ["--workers", "3"], ["--jobs", "2"], ["--scheduler", "tcp://a:1"]):
        assert main([*command, *how]) == 1
    assert asked == [None, 3, 2, "tcp://a:1"]
    assert main([*command, "--workers", "2", "--scheduler", "tcp://a:1"]) == 2
    assert "not both" in capsys.readouterr().err
