"""The commands: what they write, what they say, and how they end."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from contextlib import redirect_stderr, redirect_stdout
from html.parser import HTMLParser
from io import StringIO

import numpy as np
import pytest
from commands import rows_of, said
from pages import answers_in, texts_in
from small_campaign import TRUTH, write_campaign

import pmmkit
from pmmkit.base import SimulationError
from pmmkit.cli import main
from pmmkit.models.tables.compare import identical

ODD = "Tests <script>alert(1)</script> & more"
UNCERTAIN = ("uncertainty", "s175-3dof", "--speed", "8", "--spread", "0.1", "--ships", "2")
COLUMNS = ["Fn", "derivative", "value", "std", "ci_low", "ci_high", "method", "runs"]


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    return write_campaign(tmp_path_factory.mktemp("tests") / "small")


@pytest.fixture(scope="module")
def reduced(campaign, tmp_path_factory):
    out = tmp_path_factory.mktemp("results") / "small-reduced"
    arguments = ["--parts", "s175-3dof", "--reference", "s175-3dof", "--out", str(out)]
    assert main(["reduce", str(campaign), *arguments]) == 0
    return out


@pytest.mark.slow
def test_reduce_writes_the_files_of_the_contract(reduced):
    names = {file.name for file in reduced.iterdir()}
    assert names >= {"derivatives.csv", "derivatives.nc", "model.toml", "report.html"}
    rows = rows_of(reduced / "derivatives.csv")
    assert list(rows[0]) == COLUMNS
    assert {row["derivative"] for row in rows} == set(TRUTH)
    assert {round(float(row["Fn"]), 3) for row in rows} == {0.145, 0.29}


@pytest.mark.slow
def test_reduce_finds_the_derivatives_that_made_the_forces(reduced):
    rows = rows_of(reduced / "derivatives.csv")
    deviation = [
        (float(row["value"]) - TRUTH[row["derivative"]]) / float(row["std"]) for row in rows
    ]
    assert np.max(np.abs(deviation)) < 4.5
    assert 0.6 < np.std(deviation) < 1.4


@pytest.mark.slow
def test_a_model_that_cannot_turn_is_no_reason_to_lose_the_table(
    campaign, tmp_path, monkeypatch, capsys
):
    def diverges(*_, **__):
        raise SimulationError("it grows without bound")

    monkeypatch.setattr("pmmkit.views.report.turning.simulate", diverges)
    arguments = ["--parts", "s175-3dof", "--fn", "pooled", "--out", tmp_path / "r"]
    status, content, words = said(capsys, "reduce", campaign, *arguments)
    assert status == 0
    assert content["turns"] == []
    assert "No turning circle: it grows without bound" in words
    assert len(rows_of(tmp_path / "r" / "derivatives.csv")) == len(TRUTH)


@pytest.mark.slow
def test_both_table_files_hold_the_same(reduced):
    first = pmmkit.read_table(reduced / "derivatives.csv")
    second = pmmkit.read_table(reduced / "derivatives.nc")
    np.testing.assert_array_equal(first.value, second.value)
    assert first.names == second.names


@pytest.mark.slow
def test_every_way_to_a_derivative_is_listed(reduced):
    rows = rows_of(reduced / "derivatives_by_method.csv")
    assert list(rows[0]) == [*COLUMNS, "run", "share"]
    methods = {row["method"] for row in rows}
    assert {"static drift", "pure sway", "pure yaw", "yaw with drift"} <= methods
    assert any(row["run"] == "PS_U1_a0.3" for row in rows)


@pytest.mark.slow
def test_a_pooled_table_has_no_froude_number(campaign, tmp_path):
    assert main(["reduce", str(campaign), "--fn", "pooled", "--out", str(tmp_path / "p")]) == 0
    rows = rows_of(tmp_path / "p" / "derivatives.csv")
    assert {row["Fn"] for row in rows} == {""}
    assert len(rows) == len(TRUTH)


@pytest.fixture(scope="module")
def bare(tmp_path_factory):
    """Tests of a hull alone, with a title that a browser must not take for its own.

    Status, JSON object, words and folder of their reduction.
    """
    folder = write_campaign(tmp_path_factory.mktemp("bare") / "odd")
    toml, out = folder / "campaign.toml", folder.with_name("reduced")
    text = toml.read_text(encoding="utf-8")
    toml.write_text(text.replace("Small S175 programme", ODD), encoding="utf-8")
    with redirect_stdout(StringIO()) as result, redirect_stderr(StringIO()) as words:
        status = main(["reduce", str(folder), "--json", "--out", str(out)])
    return status, json.loads(result.getvalue()), words.getvalue(), out


@pytest.mark.slow
def test_json_is_one_object_and_the_words_go_elsewhere(bare):
    status, content, words, out = bare
    assert status == 0
    assert content["runs"] == 24
    assert {row["derivative"] for row in content["table"]} == set(TRUTH)
    assert set(content["files"]) == {file.name for file in out.iterdir()}
    assert "24 of 24" in words
    assert "Not stated in [propeller]" in " ".join(content["model_lacks"])


@pytest.mark.slow
def test_what_nobody_stated_is_estimated_and_said(bare):
    model = pmmkit.load_model(bare[-1] / "model.toml")
    assert {"propeller", "rudder_mmg"} <= set(model.parts)
    assert model.part("rudder_mmg").source.startswith("empirical")
    assert model.part("rudder_mmg").std["aH"] > 0


@pytest.mark.slow
def test_the_model_that_reduce_writes_turns_like_the_one_in_python(reduced, tmp_path):
    out = tmp_path / "turn"
    arguments = ["--manoeuvre", "turning", "--rudder-deg", "35", "--speed", "8.0"]
    model = str(reduced / "model.toml")
    assert main(["simulate", model, *arguments, "--out", str(out)]) == 0
    metrics = json.loads((out / "metrics.json").read_text(encoding="utf-8"))
    track = pmmkit.simulate(pmmkit.load_model(model), "turning", rudder_deg=35, speed=8.0)
    assert metrics["tactical_diameter_L"] == track.metrics["tactical_diameter_L"]
    assert {"advance", "transfer", "steady_diameter", "speed_ratio", "steady_drift_deg"} <= set(
        metrics
    )
    assert metrics["advance"] == pytest.approx(175.0 * metrics["advance_L"])
    assert metrics["imo"][0]["limit"] == 4.5
    assert "175 m" in metrics["scale"]
    header = (out / "track.csv").read_text(encoding="utf-8").splitlines()[0]
    assert header.split(",")[:9] == ["t", "x", "y", "psi", "u", "v", "r", "p", "phi"]


@pytest.mark.slow
def test_duration_ends_the_track(tmp_path):
    out = tmp_path / "t"
    assert main(["simulate", "s175", "--speed", "8", "--duration", "20", "--out", str(out)]) == 0
    assert float(rows_of(out / "track.csv")[-1]["t"]) == 20.0
    metrics = json.loads((out / "metrics.json").read_text(encoding="utf-8"))
    assert metrics["tactical_diameter"] is None


@pytest.mark.slow
def test_sweep_has_a_row_per_speed(tmp_path, capsys):
    out = tmp_path / "sweep"
    status, content, _ = said(capsys, "sweep", "s175-3dof", "--speeds", "6,9,12", "--out", out)
    assert status == 0
    assert [row["speed"] for row in content["sweep"]] == [6.0, 9.0, 12.0]
    # One set of derivatives for all speeds: the steady circle does not know the speed.
    diameters = [row["steady_diameter_L"] for row in content["sweep"]]
    assert np.ptp(diameters) < 1e-6
    assert len(rows_of(out / "sweep.csv")) == 3


@pytest.mark.slow
def test_a_sweep_over_any_setting_with_intervals(tmp_path, capsys):
    out = tmp_path / "sweep"
    arguments = ["--speeds", "9", "--over", "rudder_deg", "--values", "15,35"]
    more = ["--ships", "50", "--spread", "0.05", "--out", out]
    status, content, words = said(capsys, "sweep", "s175-3dof", *arguments, *more)
    assert status == 0
    for row in content["sweep"]:
        track = pmmkit.simulate("s175-3dof", speed=9.0, rudder_deg=row["rudder_deg"])
        assert row["advance_L"] == track.metrics["advance_L"]
        assert row["advance_L_low"] < row["advance_L"] < row["advance_L_high"]
    assert {file.name for file in out.iterdir()} == {"sweep.csv", "sweep.svg"}
    assert "advance_L" in words


def test_every_criterion_of_the_imo_to_both_sides(tmp_path, capsys):
    out = tmp_path / "imo"
    arguments = ["--speed", "7.97", "--spread", "0.05", "--ships", "100", "--out", out]
    status, content, words = said(capsys, "imo", "kvlcc2", *arguments)
    assert status == 0
    assert len(content["verdicts"]) == 13
    assert [row["criterion"] for row in rows_of(out / "imo.csv")] == [
        item["criterion"] for item in content["verdicts"]
    ]
    turn = pmmkit.simulate("kvlcc2", speed=7.97).metrics
    assert content["verdicts"][1]["value"] == turn["tactical_diameter_L"]
    assert "What the propeller does astern is estimated" in words
    assert "Scale: full scale" in words


def test_stability_of_an_unstable_tanker(tmp_path, capsys):
    out = tmp_path / "stability"
    status, content, words = said(capsys, "stability", "esso190k", "--speed", "8.23", "--out", out)
    assert status == 0
    assert content["stable"] is False
    assert content["C"] < 0
    assert "UNSTABLE" in words
    # Between the folds of the curve the rudder falls while the yaw rate rises.
    rows = rows_of(out / "spiral.csv")
    inside = [row for row in rows if row["stable"] == "False"]
    angles = [float(row["rudder_deg"]) for row in inside]
    assert angles == sorted(angles, reverse=True)
    assert content["loop_width_deg"] == pytest.approx(max(angles) - min(angles), rel=0.05)


@pytest.mark.slow
def test_uncertainty_and_its_causes(tmp_path, capsys):
    out = tmp_path / "u"
    arguments = ["--speed", "9", "--spread", "0.05", "--ships", "400", "--seed", "3", "--out", out]
    status, content, words = said(capsys, "uncertainty", "s175-3dof", *arguments)
    assert status == 0
    found = content["metrics"]["tactical_diameter_L"]
    assert found["low"] < found["nominal"] < found["high"]
    shares = [row["share_of_variance"] for row in content["causes"].values()]
    assert sum(shares) == pytest.approx(1.0)
    assert set(content["files"]) == {file.name for file in out.iterdir()}
    assert "400 of 400" in words
    again = said(capsys, "uncertainty", "s175-3dof", *arguments)[1]
    assert again["metrics"] == content["metrics"]


def test_a_model_from_particulars_can_be_simulated_and_scaled(tmp_path, capsys):
    out = tmp_path / "estimate"
    particulars = ["--length", "180", "--breadth", "30", "--draught", "10", "--block", "0.8"]
    status, content, words = said(
        capsys,
        "estimate",
        *particulars,
        "--speed",
        "7.5",
        "--propeller",
        "5.8",
        "--rudder",
        "40",
        "--out",
        out,
    )
    assert status == 0
    assert len(content["estimates"]) == 6
    assert {row["straight_line"] for row in content["estimates"]} == {"not settled"}
    assert "warning: yoshimura-masumoto: CB 0.80 lies outside" in words
    model = pmmkit.load_model(out / "model.toml")
    assert 2.0 < pmmkit.simulate(model, speed=7.5).metrics["tactical_diameter_L"] < 5.0
    ship = tmp_path / "ship"
    status, content, words = said(
        capsys, "scale", "kvlcc2-l7", "--length", "320", "--speed", "7.97", "--out", ship
    )
    assert status == 0
    assert content["steps"] == list(pmmkit.load_model(ship / "model.toml").history[-3:])
    assert "ITTC 1978" in words


@pytest.mark.slow
def test_compare_writes_errors_uncertainties_and_figures(campaign, tmp_path, capsys):
    out = tmp_path / "compared"
    status, content, words = said(capsys, "compare", "s175-3dof", campaign, "--out", out)
    assert status == 0
    assert (
        set(content["files"])
        == {file.name for file in out.iterdir()}
        >= {
            "comparison.csv",
            "comparison.json",
            "harmonics.csv",
            "misfit.csv",
            "misfit.png",
            "loops.png",
            "over_phase.png",
            "percent.csv",
            "static_forces.png",
            "residuals.png",
            "in_time.png",
        }
    )
    rows = rows_of(out / "comparison.csv")
    assert {"run", "channel", "error", "relative", "uncertainty", "floor"} <= set(rows[0])
    assert len(rows) == len(content["runs"]) == 3 * len({row["run"] for row in rows})
    for row in content["runs"]:
        assert row["relative"] == pytest.approx(row["error"] / row["measured"])
    assert content["floor"] == 0.005
    assert "Nothing stands out." in words
    assert content["standouts"] == []


@pytest.mark.slow
def test_compare_says_where_a_model_fails(reduced, campaign, tmp_path, capsys):
    """N_vvr taken out of the model that was reduced from these very tests."""
    model = pmmkit.load_model(reduced / "model.toml")
    zero = tuple(0.0 for _ in model.Fn)
    pmmkit.save_model(model.with_values("hull_polynomial", Nvvr=zero), tmp_path / "model.toml")
    status, content, words = said(
        capsys,
        "compare",
        tmp_path / "model.toml",
        campaign,
        "--no-figures",
        "--out",
        tmp_path / "compared",
    )
    assert status == 0
    worst = content["standouts"][0]
    assert (worst["channel"], worst["test"], worst["harmonic"]) == ("N", "yaw_drift", 1)
    assert worst["text"] in words
    assert not any(name.endswith(".png") for name in content["files"])


def test_compare_refuses_a_model_of_another_ship(campaign, tmp_path, capsys):
    status, content, words = said(capsys, "compare", "kcs", campaign, "--out", tmp_path / "no")
    assert status == 1
    assert content["error"]["type"] == "ModelError"
    assert "another ship" in words
    assert not (tmp_path / "no").exists()


@pytest.mark.slow
def test_check_is_quiet_on_sound_data_and_refuses_contradictions(campaign, tmp_path, capsys):
    status, content, _ = said(capsys, "check", campaign)
    assert (status, content["errors"]) == (0, 0)
    wrong = write_campaign(tmp_path / "wrong")
    toml = wrong / "campaign.toml"
    text = toml.read_text(encoding="utf-8")
    toml.write_text(text.replace('"hydrodynamic"', '"balance"'), encoding="utf-8")
    status, content, _ = said(capsys, "check", wrong, "--out", tmp_path / "found")
    assert status == 1
    assert content["errors"] > 0
    assert json.loads((tmp_path / "found" / "findings.json").read_text()) == content["findings"]
    out = tmp_path / "refused"
    status, content, words = said(capsys, "reduce", wrong, "--out", out)
    assert status == 1
    assert content["error"]["type"] == "ContradictionError"
    assert "inertia" in words
    assert not out.exists()


@pytest.mark.slow
def test_all_faults_of_a_campaign_are_told_with_their_places(tmp_path, capsys):
    folder = write_campaign(tmp_path / "damaged")
    first, second = sorted((folder / "runs").glob("SD_U1_*.csv"))[:2]
    first.write_text(first.read_text().replace("\n", "\nx,", 3), encoding="utf-8")
    second.write_bytes(b"")
    status, content, words = said(capsys, "reduce", folder, "--out", tmp_path / "r")
    assert status == 1
    assert "Traceback" not in words
    files = " ".join(str(problem["file"]) for problem in content["error"]["problems"])
    assert first.name in files
    assert second.name in files
    assert not (tmp_path / "r").exists()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arguments", "status"),
    [
        (["--version"], 0),
        (["ships"], 0),
        (["effects"], 0),
        (["simulate", "no-such-ship", "--speed", "8"], 1),
        (["simulate", "s175", "--speed", "-8"], 1),
        (["simulate", "s175", "--speed", "8", "--manoeuvre", "dance"], 1),
        (["reduce", "no-such-folder"], 1),
        (["sweep", "s175-3dof"], 1),
        (["convert", "no-such-table.csv", "--system", "bis"], 1),
        ([], 2),
        (["reduse"], 2),
        (["simulate", "s175"], 2),
        (["simulate", "s175", "--speed", "fast"], 2),
        (["reduce", ".", "--cycles", "three"], 2),
        (["sweep", "s175", "--speeds", "6,x"], 2),
        (["sweep", "s175", "--over", "depth", "--values", "20"], 2),
        (["sweep", "s175", "--speeds", "9", "--over", "colour", "--values", "1"], 1),
        (["imo", "s175"], 2),
        (["imo", "s175", "--speed", "-1"], 1),
        (["stability", "no-such-ship", "--speed", "8"], 1),
        (["uncertainty", "s175-3dof", "--speed", "8"], 1),
        ([*UNCERTAIN, "--metric", "beauty"], 1),
        (["scale", "kvlcc2-l7", "--length", "320"], 1),
        (["scale", "mariner", "--length", "300", "--speed", "8"], 1),
    ],
)
def test_exit_status(arguments, status, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == status
    output = capsys.readouterr()
    assert "Traceback" not in output.err
    assert (status == 0) == bool(output.out)
    assert list(tmp_path.iterdir()) == []


def test_a_usage_error_is_json_too(capsys):
    status, content, words = said(capsys, "simulate", "s175")
    assert status == 2
    assert content["error"]["type"] == "usage"
    assert "--speed" in words


@pytest.mark.slow
def test_the_installed_command_hands_its_status_on():
    code = "import sys; from pmmkit.cli import main; sys.exit(main())"
    for arguments, status in ((["ships"], 0), (["simulate", "nobody", "--speed", "1"], 1)):
        done = subprocess.run(
            [sys.executable, "-c", code, *arguments], capture_output=True, check=False
        )
        assert done.returncode == status


@pytest.mark.slow
@pytest.mark.parametrize(
    "stop",
    [
        KeyboardInterrupt,
        pytest.param("SIGTERM", marks=pytest.mark.skipif(os.name == "nt", reason="no SIGTERM")),
    ],
)
def test_a_stopped_command_leaves_nothing_behind(stop, campaign, tmp_path, monkeypatch, capsys):
    def interrupted(*_, **__):
        if stop is KeyboardInterrupt:
            raise KeyboardInterrupt
        os.kill(os.getpid(), signal.SIGTERM)

    monkeypatch.setattr("pmmkit.views.report.build.write_table", interrupted)
    before = tmp_path / "r"
    before.mkdir()
    (before / "derivatives.csv").write_text("mine")
    assert main(["reduce", str(campaign), "--out", str(before)]) == 130
    assert "Stopped" in capsys.readouterr().err
    readings = ".r-resume"  # from the third second of reading on, for the next try
    assert {file.name for file in tmp_path.iterdir()} - {readings} == {"r"}
    assert [file.read_text() for file in before.iterdir()] == ["mine"]


@pytest.mark.slow
def test_results_beside_files_of_the_user_leave_them_alone(tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    (tmp_path / "metrics.json").write_text("old")
    assert main(["simulate", "s175", "--speed", "8", "--out", str(tmp_path)]) == 0
    assert (tmp_path / "notes.txt").read_text() == "mine"
    assert "advance_L" in (tmp_path / "metrics.json").read_text(encoding="utf-8")


def test_a_file_in_the_way_is_not_replaced(tmp_path, capsys):
    target = tmp_path / "out"
    target.write_text("mine")
    assert main(["simulate", "s175", "--speed", "8", "--out", str(target)]) == 1
    assert "is a file" in capsys.readouterr().err
    assert target.read_text() == "mine"


@pytest.mark.slow
def test_convert_there_and_back(reduced, tmp_path, capsys):
    table = reduced / "derivatives.nc"
    status, content, _ = said(capsys, "convert", table, "--system", "prime-d", "--out", tmp_path)
    assert status == 0
    there = pmmkit.read_table(content["file"])
    first = pmmkit.read_table(table)
    draught = first.ship.L / first.ship.d
    np.testing.assert_allclose(there["Yv"], first["Yv"] * draught, rtol=1e-12)
    assert main(["convert", content["file"], "--system", "prime", "--out", str(tmp_path)]) == 0
    back = pmmkit.read_table(tmp_path / "derivatives-prime-d-prime.nc")
    np.testing.assert_allclose(back.value, first.value, rtol=1e-12)


@pytest.mark.slow
def test_convert_to_another_format_keeps_the_table(reduced, tmp_path):
    table = reduced / "derivatives.nc"
    assert main(["convert", str(table), "--format", "xlsx", "--out", str(tmp_path)]) == 0
    assert identical(pmmkit.read_table(tmp_path / "derivatives.xlsx"), pmmkit.read_table(table))
    assert main(["convert", str(table)]) == 1


def test_lists_for_programs(capsys):
    _, content, _ = said(capsys, "ships")
    assert {"s175", "s175-3dof"} <= {ship["name"] for ship in content["ships"]}
    _, content, _ = said(capsys, "effects")
    assert {"hull_polynomial", "propeller"} <= {effect["name"] for effect in content["effects"]}


class Loads(HTMLParser):
    """Reads a page: its tags in balance, and what it would load."""

    EMPTY = frozenset(("meta", "br", "link", "img"))

    def __init__(self):
        super().__init__()
        self.open, self.loads = [], []

    def handle_starttag(self, tag, attributes):
        if tag not in self.EMPTY:
            self.open.append(tag)
        self.loads += [value for name, value in attributes if name in ("src", "href")]

    def handle_endtag(self, tag):
        if tag not in self.EMPTY:
            assert self.open.pop() == tag


@pytest.mark.slow
def test_the_report_needs_no_other_file(reduced):
    text = (reduced / "report.html").read_text(encoding="utf-8")
    page = Loads()
    page.feed(text)
    assert page.open == page.loads == []
    assert "@import" not in text
    assert "default-src 'none'" in text


@pytest.mark.slow
def test_the_report_says_what_was_done(reduced, campaign):
    held = answers_in(reduced / "report.html")
    assert list(held["state"]["places"]) == ["data", "derivatives", "ship"]
    for place, words in {
        "data": ["abkowitz3", "Provenance", *(run.id for run in pmmkit.open_campaign(campaign))],
        "ship": ["IMO", "self-propulsion"],
    }.items():
        text = texts_in(held[f"told {place}"])
        assert [word for word in words if word not in text] == []
    assert held["derivatives"]["reference"] == "s175-3dof"


@pytest.mark.slow
def test_the_report_holds_the_derivatives_and_turns_of_the_tables(reduced):
    held = answers_in(reduced / "report.html")
    table = pmmkit.read_table(reduced / "derivatives.csv")
    low, high = table.interval()
    for row in held["derivatives"]["rows"]:
        column = table.index(row["name"])
        told = [[item["value"], item["low"], item["high"]] for item in row["values"]]
        own = np.stack([table[row["name"]], low[:, column], high[:, column]], axis=1)
        np.testing.assert_allclose(np.array(told, float), own, rtol=1e-4)
    Fn = held["turns"]["before"]["Fn"]
    metrics = json.loads((reduced / f"metrics_Fn{Fn:.3f}.json").read_text(encoding="utf-8"))
    told = {item["name"]: item["value"] for item in held["turns"]["before"]["metrics"]}
    assert told["advance_L"] == pytest.approx(metrics["advance_L"], rel=1e-4)


@pytest.mark.slow
def test_names_of_the_user_are_not_markup(bare):
    text = (bare[-1] / "report.html").read_text(encoding="utf-8")
    assert ODD not in text.partition("<script")[0]
    assert answers_in(text)["state"]["title"] == ODD


@pytest.mark.slow
def test_the_demo_finds_the_trends_that_are_in_the_synthetic_programme(tmp_path, capsys, datasets):
    import tomllib

    status, content, _ = said(capsys, "demo", "--out", tmp_path / "demo")
    assert status == 0
    truth = tomllib.loads((datasets / "s175" / "truth.toml").read_text(encoding="utf-8"))["trend"]
    found = content["changes"]
    pairs = {
        "steady_diameter_L": "steady_radius",
        "tactical_diameter_L": "tactical_diameter",
        "transfer_L": "transfer",
        "advance_L": "advance",
    }
    for ours, theirs in pairs.items():
        assert abs(found[ours] - truth[theirs]["achieved"]) < 0.015
    text = texts_in(answers_in(tmp_path / "demo" / "report.html"))
    assert "Son and Nomoto 1981" in text
    assert "5, exceeded at Fn 0.290" in text  # tactical diameter 5.3 L at 12 m/s
    assert "4.5, met" in text
