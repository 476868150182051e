"""Manoeuvres of one campaign beside those of another: in ship lengths, with both uncertainties."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

import pmmkit as pk
from pmmkit import Campaign, Run, compare_submission
from pmmkit.base import DataError
from pmmkit.campaigns import Settings
from pmmkit.cli import main
from pmmkit.identification import evaluate_trials
from pmmkit.validation import measures_in_percent

SPEED = 1.18
LARGE = 320.0 / 7.0
"""Full scale over the model of 7 m."""


@pytest.fixture(scope="module")
def turn():
    return pk.simulate("kvlcc2-l7", "turning", rudder_deg=35, speed=SPEED, compiled=False)


@pytest.fixture(scope="module")
def weave():
    return pk.simulate(
        "kvlcc2-l7", "zigzag", rudder_deg=10, switch_deg=10, speed=SPEED, compiled=False
    )


def sailed(title, *tracks, scale=1.0, wider=1.0, noise=0.0):
    """Records of tracks at another scale by Froude's law, paths wider by a factor."""
    rng = np.random.default_rng(3)
    time, pace = math.sqrt(scale), math.sqrt(scale) * wider

    def run(number, track):
        def loader():
            places = {
                name: ("t", scale * wider * getattr(track, name) + rng.normal(0, noise, len(track)))
                for name in "xy"
            }
            angles = {name: ("t", getattr(track, name)) for name in ("psi", "delta")}
            return xr.Dataset({**places, **angles}, coords={"t": time * track.t})

        degrees = {"rudder": math.radians(track.rudder_deg), "switch": math.radians(10.0)}
        switch = degrees if track.manoeuvre == "zigzag" else {"rudder": degrees["rudder"]}
        settings = Settings(speed=pace * track.speed, **switch)
        return Run(
            id=f"R{number}", test=track.manoeuvre, kind="history", settings=settings, loader=loader
        )

    ship = pk.load_ship("kvlcc2-l7" if scale == 1.0 else "kvlcc2")
    runs = tuple(run(number, track) for number, track in enumerate(tracks))
    return Campaign(title=title, kind="free-running", ship=ship, water=pk.Water(), runs=runs)


def rows(found, run=None):
    """Measures in per cent of D, as workshops table them."""
    table = measures_in_percent(found.manoeuvres)
    return table[table["run"] == run] if run else table


def errors(found, run):
    return dict(zip(rows(found, run)["measure"], rows(found, run)["E_percent"], strict=True))


def test_the_same_ship_at_another_scale_has_no_error(turn, weave):
    found = compare_submission(sailed("S", turn, weave, scale=LARGE), sailed("D", turn, weave))
    assert len(found.manoeuvres) == 2
    for _, row in found.metrics().iterrows():
        assert row["predicted"] == pytest.approx(row["measured"], rel=1e-3, abs=1e-3), row[
            "measure"
        ]


def test_a_path_that_is_three_per_cent_wider_is_three_per_cent_off(turn, weave):
    found = compare_submission(
        sailed("S", turn, weave, scale=LARGE, wider=1.03), sailed("D", turn, weave)
    )
    turned, swung = errors(found, "R0"), errors(found, "R1")
    # places come from parabolas over a time that goes by L/U: 3 per cent less of it
    for name in ("advance_L", "transfer_L", "tactical_diameter_L"):
        assert turned[name] == pytest.approx(-3.0, abs=0.1)
    assert swung["overshoot_1_deg"] == pytest.approx(0.0, abs=0.01)


def test_the_uncertainty_is_that_of_both(turn):
    """Fixes with noise on one side, on the other, on both: squares add."""
    one, other, both = (
        next(
            row
            for _, row in rows(
                compare_submission(sailed("S", turn, noise=theirs), sailed("D", turn, noise=ours))
            ).iterrows()
            if row["measure"] == "tactical_diameter_L"
        )
        for theirs, ours in ((0.0, 0.1), (0.1, 0.0), (0.1, 0.1))
    )
    assert one["U_D_percent"] == pytest.approx(both["U_D_percent"])
    assert both["U_V_percent"] == pytest.approx(
        math.hypot(one["U_V_percent"], other["U_V_percent"]), rel=0.05
    )
    assert both["U_V_percent"] > 1.2 * both["U_D_percent"] > 0.0


def test_a_trial_of_another_size_is_the_same_in_ship_lengths(turn):
    (trial,) = evaluate_trials(sailed("D", turn))
    large = trial.resized(320.0, 8.0)
    for name, value in trial.metrics.items():
        if name.endswith("_L"):
            assert large.metrics[name] == value
            assert large.metrics[name.removesuffix("_L")] == pytest.approx(320.0 * value)
    assert large.metrics["time_90"] / (320.0 / 8.0) == pytest.approx(
        trial.metrics["time_90"] / (trial.L / trial.speed)
    )


def test_it_is_told_as_a_comparison_with_a_model_is(turn, weave):
    found = compare_submission(sailed("S", turn, wider=1.03), sailed("D", turn, weave))
    said = str(found)
    assert said.startswith("Comparison S beside D: 1 manoeuvre, error within its uncertainty in")
    assert "Manoeuvres, submitted" in said
    assert "R0 tactical diameter [m]" in said
    assert "Root mean square errors" not in said
    for _, row in found.metrics().iterrows():
        assert row["error"] == row["predicted"] - row["measured"], "one sign, whoever predicts"
    assert found.to_dict()["runs"] == []


def test_manoeuvres_without_a_common_measure_are_an_empty_table(turn):
    found = compare_submission(sailed("S", turn), sailed("D", turn)).manoeuvres
    bare = [replace(item, track=replace(item.track, metrics={})) for item in found]
    assert measures_in_percent(bare).empty
    assert list(measures_in_percent(bare).columns) == list(measures_in_percent(found).columns)


def test_what_has_no_counterpart_is_named(turn, weave):
    found = compare_submission(sailed("S", turn), sailed("D", turn, weave))
    assert found.notes == ("Without a counterpart in the submission: R1.",)
    with pytest.raises(DataError, match="has the orders of one"):
        compare_submission(sailed("S", weave), sailed("D", turn))
    with pytest.raises(DataError, match="is captive and"):
        compare_submission(sailed("S", turn).with_(kind="captive"), sailed("D", turn))


def test_the_command_compares_two_laboratories(turn, weave, tmp_path, capsys):
    for title, wider in (("S", 1.03), ("D", 1.0)):
        tests = sailed(title, turn, weave, wider=wider)
        pk.save_campaign(tests, tmp_path / f"{title}.h5")
    command = ["compare", str(tmp_path / "S.h5"), str(tmp_path / "D.h5")]
    assert main([*command, "--out", str(tmp_path / "out"), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert {row["measure"] for row in told["manoeuvres"]} > {"advance_L", "overshoot_1_deg"}
    written = {path.name for path in (tmp_path / "out").iterdir()}
    assert written == {
        *("percent.csv", "manoeuvres.csv", "comparison.json"),
        *("turning_circles.png", "zigzag.png"),
    }
