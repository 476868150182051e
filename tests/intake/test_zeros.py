"""Zeros of gauges that drift over the day: named, shown run by run, and taken off in one line."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from own_tank import drift, sway, write, yaw

import pmmkit as pk
from pmmkit.base import CampaignError
from pmmkit.cli import main
from pmmkit.intake import CheckFinding

TESTS = (
    *(drift(beta) for beta in (-8, -4, 0, 4, 8, 12)),
    *(sway(9.0, a, 2.3) for a in (0.25, 0.4)),
    *(yaw(9.0, a, 2.3) for a in (8.0, 13.0)),
)
DAY = np.linspace(0.0, 1.0, len(TESTS))
LEAD = {"rest": 3.0, "ramp": 4.0, "together": True}
TARE = "[defaults]\ntare = true\n"


def drifting(folder: Path, head: str = "", **more) -> Path:
    """A side force gauge that shows 6 N more at the end of the day, and 0.4 N at its beginning."""
    return write(folder, TESTS, zeros={"Y": 0.4 + 6.0 * DAY}, head=head, **LEAD, **more)


def said(folder: Path) -> list[CheckFinding]:
    return [item for item in pk.examine(pk.open_campaign(folder)) if item.check == "zeros"]


def test_a_drift_over_the_day_is_named_with_its_size_and_remedy(tmp_path):
    (found,) = said(drifting(tmp_path / "c"))
    assert found.severity == "warning"
    assert "tare = true under [defaults]" in found.remedy
    assert found.numbers == {"Y_range": pytest.approx(6.0, abs=0.3)}
    assert "from the first run to the last" in found.message
    assert "as the campaign file has them" in found.message
    shown = np.array([own["Y"] for own in found.by_run.values()])
    doubt = np.array([own["Y_std"] for own in found.by_run.values()])
    assert np.all(np.abs(shown - 0.4 - 6.0 * DAY) < 4.5 * doubt)
    assert list(found.by_run) == [test.name for test in TESTS]


def test_one_line_takes_it_off_and_says_what_it_took(tmp_path):
    (found,) = said(drifting(tmp_path / "c", TARE))
    assert found.severity == "info"
    assert "taken off each record" in found.message
    shown = np.array([own["Y"] for own in found.by_run.values()])
    np.testing.assert_allclose(shown, 0.4 + 6.0 * DAY, atol=0.4)
    bare = write(tmp_path / "sound", TESTS, **LEAD)
    for one, other in zip(pk.open_campaign(tmp_path / "c"), pk.open_campaign(bare), strict=True):
        left = one.data["Y"].values - other.data["Y"].values
        assert abs(left.mean()) < 0.3


@pytest.mark.parametrize("size", [0.0, 1.5])
def test_a_zero_that_stays_is_no_drift(size, tmp_path):
    folder = write(tmp_path / "c", TESTS, zeros={"Y": np.full(len(TESTS), size)}, **LEAD)
    assert said(folder) == []


def test_zeros_that_wander_are_told_without_a_line(tmp_path):
    wander = 3.0 * np.sin(2.0 * np.pi * DAY * 2.5)
    (found,) = said(write(tmp_path / "c", TESTS, zeros={"N": wander}, **LEAD))
    assert "from the first run to the last" not in found.message
    assert found.numbers == {"N_range": pytest.approx(float(np.ptp(wander)), abs=0.4)}


def test_records_that_begin_on_the_way_have_no_zeros(tmp_path):
    assert said(write(tmp_path / "c", TESTS, zeros={"Y": 6.0 * DAY})) == []


def test_the_order_is_that_of_the_clock_where_runs_state_it(tmp_path):
    """The file lists the runs by angle; they were made in another order."""
    folder = drifting(tmp_path / "c")
    file = folder / "campaign.toml"
    head, *runs = file.read_text().split("\n[[runs]]\n")
    order = np.random.default_rng(4).permutation(len(runs))
    timed = [
        f"started = 2026-05-04T{9 + place // 4:02d}:{15 * (place % 4):02d}:00\n{runs[place]}"
        for place in order
    ]
    file.write_text("\n[[runs]]\n".join([head, *timed]))
    campaign = pk.open_campaign(folder)
    assert campaign.places_in_day == pytest.approx(order / (len(runs) - 1))
    pk.export(campaign, tmp_path / "csv", to="csv")
    pk.save_campaign(campaign, tmp_path / "all.h5")
    for again in (tmp_path / "csv", tmp_path / "all.h5"):
        assert [run.started for run in pk.open_campaign(again)] == [x.started for x in campaign]
    (found,) = said(folder)
    assert "by the times at which they started" in found.message
    assert list(found.by_run) == [test.name for test in TESTS]


def test_what_a_run_states_counts_before_the_defaults(tmp_path):
    folder = drifting(tmp_path / "c", TARE)
    file = folder / "campaign.toml"
    text = file.read_text()
    name = TESTS[5].name
    file.write_text(text.replace(f'id = "{name}"', f'id = "{name}"\ntare = false'))
    campaign = pk.open_campaign(folder)
    assert "tared" not in campaign[name].data.attrs
    assert set(json.loads(campaign[TESTS[4].name].data.attrs["tared"])) == {"X", "Y", "N"}


def test_where_the_rest_is_may_be_stated(tmp_path):
    head = '[defaults]\ntare = { t_start = -7.0, t_end = -4.5, channels = ["Y"] }\n'
    campaign = pk.open_campaign(drifting(tmp_path / "c", head))
    zero, std = json.loads(campaign.runs[-1].data.attrs["tared"])["Y"]
    assert zero == pytest.approx(6.4, abs=5 * std)
    assert std < 0.2


def test_of_one_kind_of_test_alone(tmp_path):
    campaign = pk.open_campaign(drifting(tmp_path / "c", "[defaults.pure_sway]\ntare = true\n"))
    tared = [run.test for run in campaign if "tared" in run.data.attrs]
    assert tared == ["pure_sway", "pure_sway"]


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ('tare = "yes"', "must be true, false, or a table such as"),
        ("tare = { t_begin = 0.0 }", "did you mean 't_end'"),
        ('tare = { channels = ["Z"] }', "is not one of X, Y, N, K"),
    ],
)
def test_a_tare_that_is_none_is_refused(line, words, tmp_path):
    with pytest.raises(CampaignError) as caught:
        pk.open_campaign(drifting(tmp_path / "c", f"[defaults]\n{line}\n"))
    assert words in str(caught.value)


def test_a_record_without_rest_is_not_tared_in_silence(tmp_path):
    folder = write(tmp_path / "c", TESTS, head=TARE)
    with pytest.raises(CampaignError, match="tare = false where"):
        pk.examine(pk.open_campaign(folder))


def test_rows_of_a_table_take_no_tare_from_the_defaults(tmp_path):
    """Means have no rest; who asks for their tare is refused."""
    from own_tank import HEAD

    (tmp_path / "means.csv").write_text("beta,X,Y,N\n0,-24,0.1,0.2\n4,-25,12,9\n")
    text = (
        f'{HEAD}\n{TARE}\n[[tables]]\nid = "SD_{{beta}}"\ntest = "static_drift"\nspeed = 1.2\n'
        'file = "means.csv"\n{}columns = { drift_deg = "beta" }\n'
    )
    (tmp_path / "campaign.toml").write_text(text.replace("{}", ""))
    assert len(pk.open_campaign(tmp_path).runs) == 2
    (tmp_path / "campaign.toml").write_text(text.replace("{}", "tare = true\n"))
    with pytest.raises(CampaignError, match="no rest to tare by"):
        pk.open_campaign(tmp_path)


def test_the_console_and_its_folder_show_the_zeros(tmp_path, capsys):
    folder = drifting(tmp_path / "c")
    main(["check", str(folder), "--out", str(tmp_path / "out")])
    text = capsys.readouterr().out
    assert "Y at rest [N]" in text
    assert TESTS[3].name in text
    assert (tmp_path / "out" / "zeros.svg").read_text().count("at rest") >= 3
    written = json.loads((tmp_path / "out" / "findings.json").read_text())
    (zeros,) = (item for item in written if item["check"] == "zeros")
    assert zeros["by_run"][TESTS[-1].name]["Y"] == pytest.approx(6.4, abs=0.4)


@pytest.mark.slow
def test_the_report_shows_them(tmp_path):
    from pmmkit.views.report.build import page_file, reduction_answers

    reduction = pk.reduction.reduce_campaign(
        pk.open_campaign(drifting(tmp_path / "c", TARE)), structure="abkowitz3", fn="pooled"
    )
    page = page_file(reduction_answers(reduction))
    assert "Zeros of the gauges at rest, run by run" in page
    assert "Y at rest" in page
