"""A zero of the surge gauge: found at rest, taken off by a tare, told where it is left inside."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
import small_campaign
from small_campaign import TRUTH, write_campaign

import pmmkit as pk
from pmmkit.base import CampaignError
from pmmkit.intake import CheckFinding

ZERO = {"X": -0.8, "Y": 0.5}
TARE = '\n[[corrections]]\nruns = ["*"]\naction = "tare"\nreason = "the carriage stands at first"\n'


@pytest.fixture(scope="module")
def resting(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_campaign(tmp_path_factory.mktemp("zero") / "c", noise=0.3, rest=3.0, zero=ZERO)


def tared(folder: Path, text: str = TARE) -> Path:
    """The campaign file beside the first one, with a correction."""
    path = folder / f"tared{abs(hash(text))}.toml"
    path.write_text((folder / "campaign.toml").read_text() + text)
    return path


def sigmas(campaign: pk.Campaign, name: str = "Xuu") -> float:
    """How many of its standard uncertainties a pooled value lies from the truth."""
    table = pk.reduce(campaign, structure="abkowitz3", fn="pooled")
    place = table.index(name)
    return float((table[name][0] - TRUTH[name]) / table.std[0][place])


@pytest.mark.slow
def test_a_tare_takes_the_zero_off(resting):
    assert abs(sigmas(pk.open_campaign(resting))) > 8
    campaign = pk.open_campaign(tared(resting))
    assert abs(sigmas(campaign)) < 3.5
    told = campaign["SD_U1_b+00"].data.attrs["conversions"]
    assert "tared by" in told
    assert re.search(r"X -0\.[78]\d+\(\d+\) N", told)


def test_stated_times_and_channels_serve_as_well(resting):
    text = TARE + 'channels = ["X"]\nt_start = -5.0\nt_end = -2.2\n'
    plain, some = pk.open_campaign(resting), pk.open_campaign(tared(resting, text))
    name = "SD_U2_b+08"
    before, after = plain[name].data, some[name].data
    assert float((before["X"] - after["X"]).mean()) == pytest.approx(ZERO["X"], abs=0.15)
    assert np.array_equal(before["Y"], after["Y"])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (TARE + "t_start = 400.0\n", "fewer than 16 samples"),
        (TARE + 'channels = ["K"]\n', "K"),
        (TARE + "factor = 2.0\n", "does not use factor"),
    ],
)
def test_a_tare_that_cannot_be_is_refused(resting, text, message):
    with pytest.raises(CampaignError, match=message):
        _ = pk.open_campaign(tared(resting, text))["SD_U1_b+00"].data


def test_records_without_a_rest_are_not_tared_in_silence(tmp_path):
    folder = write_campaign(tmp_path / "c", noise=0.3, zero=ZERO)
    with pytest.raises(CampaignError, match="finds no rest at the head"):
        _ = pk.open_campaign(tared(folder))["SD_U1_b+00"].data


@pytest.mark.slow
def test_the_checks_offer_the_tare_and_are_silent_after_it(resting):
    (found,) = (f for f in pk.examine(pk.open_campaign(resting)) if f.check == "rest")
    assert found.severity == "warning"
    assert len(found.runs) == len(pk.open_campaign(resting).runs)
    assert found.numbers["X"] == pytest.approx(ZERO["X"], abs=0.05)
    assert found.numbers["Y"] == pytest.approx(ZERO["Y"], abs=0.1)
    assert 'action = "tare"' in found.remedy
    assert not [f for f in pk.examine(pk.open_campaign(tared(resting))) if f.check == "rest"]


@pytest.mark.slow
def test_gauges_that_show_zero_at_rest_are_nothing_to_tell(tmp_path):
    folder = write_campaign(tmp_path / "c", noise=0.3, rest=3.0)
    assert not [f for f in pk.examine(pk.open_campaign(folder)) if f.check == "rest"]


@pytest.mark.slow
def test_a_common_zero_of_surge_is_named_where_speeds_show_it(tmp_path):
    """Without any rest: two speeds tell a constant force from one that grows with u²."""
    folder = write_campaign(tmp_path / "c", noise=0.3, zero=ZERO)
    (found,) = zeros(folder)
    assert found.severity == "warning"
    assert found.numbers["zero"] == pytest.approx(ZERO["X"], abs=5 * found.numbers["std"])
    assert found.numbers["Xuu"] == pytest.approx(TRUTH["Xuu"], rel=0.01)
    assert "tare" in found.remedy
    assert not zeros(write_campaign(tmp_path / "clean", noise=0.3))


def zeros(folder: Path, fn: str = "pooled") -> list[CheckFinding]:
    """What the reduction says of a zero of X."""
    found = pk.reduce_campaign(pk.open_campaign(folder), fn=fn).findings
    return [item for item in found if item.check == "surge zero"]


@pytest.mark.slow
def test_sets_of_each_speed_tell_a_zero_by_their_resistance(tmp_path, monkeypatch):
    monkeypatch.setattr(small_campaign, "SPEEDS", (1.0, 1.5, 2.0))
    folder = write_campaign(tmp_path / "c", noise=0.3, zero=ZERO)
    (found,) = zeros(folder, "each")
    assert found.numbers["zero"] == pytest.approx(ZERO["X"], abs=0.1)
    assert found.numbers["Xuu"] == pytest.approx(TRUTH["Xuu"], rel=0.01)
    assert not zeros(write_campaign(tmp_path / "clean", noise=0.3), "each")


@pytest.mark.slow
def test_a_hull_that_changes_with_speed_is_not_a_zero_of_the_gauge(datasets):
    """The S175 programme in one set over its speeds: all derivatives change, not X alone."""
    whole = pk.open_campaign(datasets / "s175")
    found = pk.reduce_campaign(whole.with_(runs=whole.runs[::2]), fn="pooled").findings
    told = [item for item in found if item.check in ("rest", "surge zero")]
    assert all(item.severity == "info" for item in told)


@pytest.mark.slow
def test_the_console_mentions_both(resting, tmp_path, capsys):
    from pmmkit.cli import main

    assert main(["reduce", str(resting), "--fn", "pooled", "--out", str(tmp_path / "out")]) == 0
    said = capsys.readouterr().out
    assert "warning: rest" in said
    assert 'action = "tare"' in said
    assert "warning: surge zero: A zero of the surge gauge" in said
