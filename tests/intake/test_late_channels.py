"""Channels of which a logger lost or repeated a value: late or early from there on."""

from __future__ import annotations

import math

import numpy as np
import pytest
from checks_programme import campaign_of, run_of

from pmmkit.intake import examine

TESTS = {
    "pure_sway": {"period": 12.5, "amplitude": 0.3},
    "pure_yaw": {"period": 12.5, "yaw_amplitude": math.radians(12)},
    "yaw_drift": {"period": 12.5, "yaw_amplitude": math.radians(12), "drift": math.radians(6)},
}


def said(runs):
    return [item for item in examine(campaign_of(runs)) if item.check == "late channels"]


def lost(channel, samples, share):
    """The values of a channel from some part of the record on are those of other rows."""

    def change(run, data):
        values = data[channel].values
        start = int(share * len(values))
        rows = np.arange(len(values))
        rows = np.where(rows < start, rows, np.minimum(rows - samples, len(values) - 1))
        return data.assign({channel: ("t", values[rows])})

    return change


@pytest.mark.parametrize("test", TESTS)
@pytest.mark.parametrize("channel", ["Y", "N"])
@pytest.mark.parametrize(("samples", "share"), [(1, 0.5), (2, 0.35), (3, 0.5), (-2, 0.6)])
def test_a_channel_that_is_late_from_some_time_on(test, channel, samples, share):
    run = run_of("A", test, change=lost(channel, samples, share), **TESTS[test])
    (found,) = said([run])
    word = "late" if samples > 0 else "early"
    count = "1 sample" if abs(samples) == 1 else f"{abs(samples)} samples"
    assert found.message.startswith(f"{channel} is {word} by {count} from t = ")
    assert (found.severity, found.runs, found.channels) == ("warning", ("A",), (channel,))
    assert found.numbers["samples"] == samples
    assert found.numbers["from"] == pytest.approx(share * 65.0, abs=3.0)


def test_a_surge_force_of_yaw_with_drift_is_told_too():
    """In noise of 2 % of its swing; that of the tests above, of the side force, is 20 % of it."""
    run = run_of("A", "yaw_drift", change=lost("X", 3, 0.5), noise=0.001, **TESTS["yaw_drift"])
    assert [item.channels for item in said([run])] == [("X",)]


def test_several_runs_are_told_in_one_sentence():
    runs = [
        run_of(name, "pure_sway", change=lost("Y", 2, 0.5), **TESTS["pure_sway"]) for name in "AB"
    ]
    (found,) = said([*runs, run_of("C", "pure_sway", **TESTS["pure_sway"])])
    assert found.runs == ("A", "B")
    assert "so in 2 of 3 runs" in found.message


def test_the_channel_is_not_blamed_on_anything_else():
    """Its cycles differ, too; one cause is told once."""
    run = run_of("A", "pure_sway", change=lost("Y", 3, 0.5), **TESTS["pure_sway"])
    found = [item for item in examine(campaign_of([run])) if "Y" in item.message.split()]
    assert [item.check for item in found if item.severity != "info"] == ["late channels"]


@pytest.mark.parametrize("test", TESTS)
@pytest.mark.parametrize("noise", [0.01, 0.1, 0.5])
def test_sound_runs_are_silent(test, noise):
    runs = [run_of(f"{k}", test, noise=noise, **TESTS[test]) for k in range(4)]
    assert said(runs) == []


def test_forces_that_grow_or_change_their_size_are_not_late():
    def grown(run, data):
        return data.assign(Y=data["Y"] * (1 + 0.1 * (data["t"] > 30)))

    assert said([run_of("A", "pure_sway", change=grown, **TESTS["pure_sway"])]) == []


def test_a_run_that_is_late_throughout_is_not_told_here():
    """Its phase is that of damping and added mass; the other runs may tell (`agreement`)."""
    run = run_of("A", "pure_sway", change=lost("Y", 3, 0.0), **TESTS["pure_sway"])
    assert said([run]) == []
