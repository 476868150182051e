"""Identification from the command line: records, priors, methods, files, figures, words."""

from __future__ import annotations

import csv
import json
import math
import warnings

import numpy as np
import pytest
from commands import rows_of, said

import pmmkit as pk
from pmmkit import FreeRecord, compare_methods
from pmmkit.base import DataError, UnknownNameError
from pmmkit.cli import main
from pmmkit.conventions import Convention
from pmmkit.identification import PredictedWindow, Smoothed, known_before
from pmmkit.identification.figures import parameters
from pmmkit.identification.known import parameters_of
from pmmkit.identification.methods import SECONDS
from pmmkit.identification.posterior.tree import read_posterior
from pmmkit.inference import Consistency, Innovations
from pmmkit.inference.innovations import autocorrelation
from pmmkit.views.figures import identification as drawings

SHIP, SPEED = "kvlcc2-l7", 1.179
NOISE = {"x": 0.02, "y": 0.02, "psi": math.radians(0.1), "r": math.radians(0.05)}
RUNS = {"ZZ10": (10, 10), "ZZ20": (-20, 20), "ZZ15": (15, 15), "ZZ35": (35, 5)}
NAMES = ("Yv", "Nv", "Nr")
START = {"Yv": -0.25, "Nv": -0.12, "Nr": -0.055}
COLUMNS = ["parameter", "prior", "prior_std", "value", "std", "ci_low", "ci_high", "seen", "method"]
HEAD = """\
[campaign]
title = "Made-up zigzags"
kind = "{kind}"

[ship]
name = "KVLCC2 L7"
L = {L}
B = 1.27
d = 0.46
volume = 3.27
mass = 3270.0
Izz = 10218.75
xG = 0.25

[water]
rho = 1000.0
g = 9.81
"""
RUN = """
[[runs]]
id = "{name}"
test = "zigzag"
file = "{name}.csv"
speed = 1.179
rudder_deg = {rudder}
switch_deg = {switch}
"""


def sailed(name):
    """A zigzag of the library ship."""
    rudder, switch = RUNS[name]
    return pk.simulate(SHIP, "zigzag", speed=SPEED, rudder_deg=rudder, switch_deg=switch, dt=0.5)


def noisy(name):
    """Its channels as sensors see them."""
    track, rng = sailed(name), np.random.default_rng([3, len(name), abs(RUNS[name][0])])
    seen = {
        key: getattr(track, key) + std * rng.normal(size=len(track)) for key, std in NOISE.items()
    }
    return {"t": track.t, **seen, "delta": track.delta, "n": track.n}


def write_free_campaign(folder, L=7.0, without=()):
    folder.mkdir(parents=True, exist_ok=True)
    text = HEAD.format(kind="free-running", L=L)
    for name, (rudder, switch) in RUNS.items():
        text += RUN.format(name=name, rudder=rudder, switch=switch)
        columns = {key: x for key, x in noisy(name).items() if key not in without}
        with (folder / f"{name}.csv").open("w", encoding="utf-8", newline="") as stream:
            writer = csv.writer(stream)
            writer.writerow(columns)
            writer.writerows(zip(*(x.tolist() for x in columns.values()), strict=True))
    (folder / "campaign.toml").write_text(text, encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    return write_free_campaign(tmp_path_factory.mktemp("free") / "zigzags")


@pytest.fixture(scope="module")
def start(tmp_path_factory):
    """A model file whose derivatives are off."""
    path = tmp_path_factory.mktemp("start") / "start.toml"
    pk.save_model(pk.load_model(SHIP).with_values("hull_polynomial", **START), path)
    return path


@pytest.fixture(scope="module")
def records():
    made = []
    for name in RUNS:
        own = noisy(name)
        measured = {key: own[key] for key in NOISE}
        made.append(
            FreeRecord(
                name=name,
                t=own["t"],
                delta=own["delta"],
                turns=own["n"],
                measured=measured,
                speed=SPEED,
            )
        )
    return made


@pytest.fixture(scope="module")
def compared(records):
    model = pk.load_model(SHIP).with_values("hull_polynomial", **START)
    references = Smoothed.references(model, records[3:], sensors=NOISE)
    names = [*NAMES, "rudder_mmg.aH"]
    return compare_methods(
        model, records[:3], names, references=references, spread=0.2, sensors=NOISE
    ), references


def identified(capsys, campaign, start, out, *options):
    """Status, JSON object and words of an identification into a folder."""
    return said(capsys, "identify", campaign, "--model", start, *options, "--out", out)


@pytest.mark.slow
def test_a_posterior_is_written_with_how_well_its_ensembles_agree(
    campaign, start, tmp_path, capsys
):
    pytest.importorskip("emcee", reason="emcee is not installed")
    (tmp_path / "short").mkdir()
    lines = (campaign / "ZZ10.csv").read_text(encoding="utf-8").splitlines()
    short = "\n".join([lines[0], *lines[1:64:2]])
    (tmp_path / "short" / "ZZ10.csv").write_text(short, encoding="utf-8")
    head = HEAD.format(kind="free-running", L=7.0)
    run = RUN.format(name="ZZ10", rudder=10, switch=10)
    (tmp_path / "short" / "campaign.toml").write_text(head + run, encoding="utf-8")
    out = tmp_path / "found"
    status, content, words = identified(
        capsys,
        tmp_path / "short",
        start,
        out,
        *("--method", "posterior", "--derivatives", "Nr", "--shortest", "20", "--window", "10"),
        *("--steps", "60", "--seed", "3"),
    )
    assert status == 0
    assert {"posterior.nc", "posterior.svg", "model.toml"} <= set(content["files"])
    own = content["methods"]["posterior"]
    told = own["convergence"]["Nr"]
    agree = [x["r_hat"] < 1.01 and x["ess_tail"] > 400 for x in own["convergence"].values()]
    assert own["converged"] <= all(agree)
    assert f"R-hat at most {max(x['r_hat'] for x in own['convergence'].values()):.3f}" in words
    assert told["ess_bulk"] > 0
    tree = read_posterior(out / "posterior.nc")
    assert tree.attrs["seed"] == 3
    np.testing.assert_array_equal(tree["convergence/r_hat"][0], told["r_hat"])
    assert pk.load_model(out / "model.toml").covariance_names == ("Nr",)


@pytest.mark.slow
def test_one_method_writes_its_files_and_predicts_what_was_held_out(
    campaign, start, tmp_path, capsys
):
    out = tmp_path / "found"
    status, content, words = identified(
        capsys,
        campaign,
        start,
        out,
        "--derivatives",
        "Yv Nv,Nr",
        "--spread",
        "0.2",
        "--test-runs",
        "ZZ35",
    )
    assert status == 0
    names = {
        "identified.csv",
        "model.toml",
        "predictions.csv",
        "identified.json",
        "parameters.svg",
        "history_ekf.svg",
        "innovations_ekf.svg",
        "prediction.svg",
    }
    assert {file.name for file in out.iterdir()} == set(content["files"]) == names
    rows = rows_of(out / "identified.csv")
    assert list(rows[0]) == COLUMNS
    assert [row["parameter"] for row in rows] == list(NAMES)
    truth = pk.load_model(SHIP).values("hull_polynomial")
    for row in rows:
        assert abs(float(row["value"]) - truth[row["parameter"]]) < 4.5 * float(row["std"])
        assert float(row["prior"]) == START[row["parameter"]]
        assert (row["seen"], row["method"]) == ("True", "ekf")
    made = pk.load_model(out / "model.toml")
    assert made.values("hull_polynomial")["Nv"] == float(rows[1]["value"])
    assert made.covariance_names == NAMES
    assert content["used"]["runs"] == ["ZZ10", "ZZ20", "ZZ15"]
    assert [item["name"] for item in content["held_out"]["records"]] == ["ZZ35"]
    before, after = content["errors_before"], content["methods"]["ekf"]["errors"]
    assert set(before) == {"ZZ35", "all"}
    assert after["all"]["yaw_rate"] < 0.5 * before["all"]["yaw_rate"]
    predictions = rows_of(out / "predictions.csv")
    assert [row["model"] for row in predictions] == ["before", "before", "ekf", "ekf"]
    assert {row["held_out"] for row in predictions} == {"True"}
    stored = json.loads((out / "identified.json").read_text(encoding="utf-8"))
    assert stored["methods"] == content["methods"]
    assert "Used: 3 records from 3 runs" in words
    assert "of the runs held out" in words
    assert "identify by ekf" in words


@pytest.mark.slow
def test_all_methods_side_by_side(campaign, start, tmp_path, capsys):
    out = tmp_path / "all"
    status, content, words = identified(
        capsys,
        campaign,
        start,
        out,
        "--method",
        "all",
        "--spread",
        "0.2",
        "--derivatives",
        "Yv Nv Nr rudder_mmg.aH",
        "--test-runs",
        "ZZ35",
    )
    assert status == 0
    assert (tuple(content["methods"]), content["failed"]) == (SECONDS, {})
    assert {f"model_{name}.toml" for name in SECONDS} <= set(content["files"])
    assert {"innovations_ekf.svg", "history_ukf.svg"} <= set(content["files"])
    rows = rows_of(out / "identified.csv")
    assert [row["method"] for row in rows].count("trajectory") == 4
    assert [row["method"] for row in rows].count("sindy") == 3
    for item in content["methods"].values():
        assert item["errors"]["all"]["yaw_rate"] < content["errors_before"]["all"]["yaw_rate"]
        assert item["seconds"] > 0
    assert content["methods"]["trajectory"]["consistency"] is None
    assert content["methods"]["ukf"]["consistency"][0]["record"] == "all"
    line = next(line for line in words.splitlines() if line.startswith("rudder_mmg.aH"))
    assert line.split()[-1] == "held"


@pytest.mark.slow
def test_without_runs_held_out_it_says_so(campaign, start, tmp_path, capsys):
    status, content, words = identified(
        capsys,
        campaign,
        start,
        tmp_path / "t",
        "--method",
        "trajectory",
        "--derivatives",
        "Nv",
        "--runs",
        "ZZ1*",
        "--channels",
        "x,y,psi",
        "--window",
        "40",
        "--no-wind",
    )
    assert status == 0
    assert content["held_out"] is None
    assert content["used"]["runs"] == ["ZZ10", "ZZ15"]
    assert content["used"]["records"][0]["channels"] == ["x", "y", "psi"]
    assert "which is no test" in words
    assert "history" not in " ".join(content["files"])


@pytest.mark.slow
def test_sensors_stated_and_a_current(campaign, start, tmp_path, capsys):
    status, content, _ = identified(
        capsys,
        campaign,
        start,
        tmp_path / "t",
        "--derivatives",
        "Nv current_x",
        "--runs",
        "ZZ10",
        "--sensors",
        "x=0.02,y=0.02,psi_deg=0.1,r_deg=0.05",
    )
    assert status == 0
    rows = {row["parameter"]: row for row in content["methods"]["ekf"]["parameters"]}
    assert abs(rows["current_x"]["value"]) < 0.05
    whole = {row["channel"]: row["nis"] for row in content["methods"]["ekf"]["consistency"]}
    assert 0.7 < whole["x"] < 1.4
    step = pk.load_model(tmp_path / "t" / "model.toml").steps[-1]
    assert (step.effect, step.coefficients["current_y"]) == ("current", 0.0)
    assert step.coefficients["current_x"] == pytest.approx(rows["current_x"]["value"])


@pytest.mark.slow
def test_what_the_records_do_not_determine_is_named_and_kept(campaign, start, tmp_path, capsys):
    out = tmp_path / "t"
    status, content, words = identified(
        capsys,
        campaign,
        start,
        out,
        "--derivatives",
        "Nv Nrrr",
        "--runs",
        "ZZ10",
        "--spread",
        "0.02",
    )
    assert status == 0
    assert content["methods"]["ekf"]["unseen"] == ["Nrrr"]
    assert "do not determine Nrrr" in words
    kept = pk.load_model(out / "model.toml").values("hull_polynomial")["Nrrr"]
    assert kept == pk.load_model(start).values("hull_polynomial")["Nrrr"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--derivatives", "Yv Nqq"], ["no Nqq", "Yv, Yr", "rudder_mmg.aH", "current_x"]),
        (["--derivatives", ","], ["at least one parameter"]),
        (["--runs", "turn*"], ["turn*", "ZZ10, ZZ20, ZZ15, ZZ35"]),
        (["--test-runs", "ZZ35,spiral"], ["called spiral", "ZZ10"]),
        (["--test-runs", "*"], ["Every run is held out"]),
        (["--channels", "x,y,psi,u"], ["no u", "x, y, psi, r"]),
        (["--window", "1000"], ["1000 s", "the longest"]),
        (["--shortest", "1000"], ["No record is long enough"]),
        (["--sensors", "x=0.1,z=1"], ["no channel z", "x, y, psi"]),
        (["--prior", "nothing"], ["nothing", "kvlcc2"]),
        (["--prior", "nothing.csv"], ["nothing.csv"]),
    ],
)
def test_wrong_requests_are_answered_with_what_exists(
    campaign, start, tmp_path, capsys, arguments, words
):
    out = tmp_path / "t"
    status, content, _ = identified(capsys, campaign, start, out, *arguments)
    assert status == 1
    assert [word for word in words if word not in content["error"]["message"]] == []
    assert not out.exists()


@pytest.mark.parametrize(
    "arguments",
    [["--method", "kalman"], ["--spread", "0"], ["--window", "-1"], ["--sensors", "x"], []],
)
def test_usage(campaign, start, capsys, arguments):
    model = ["--model", str(start)] if arguments else []
    assert main(["identify", str(campaign), *model, *arguments]) == 2
    capsys.readouterr()


@pytest.mark.slow
def test_other_ships_and_captive_campaigns_are_refused(tmp_path, capsys, campaign, datasets):
    assert main(["identify", str(campaign), "--model", "kvlcc2", "--out", str(tmp_path / "a")]) == 1
    assert "pmmkit scale kvlcc2 --length 7" in capsys.readouterr().err
    assert (
        main(["identify", str(datasets / "s175"), "--model", "s175", "--out", str(tmp_path / "b")])
        == 1
    )
    assert "captive" in capsys.readouterr().err


def test_a_record_without_rudder_is_refused(tmp_path, capsys, start):
    folder = write_free_campaign(tmp_path / "bare", without=("n",))
    assert main(["identify", str(folder), "--model", str(start), "--out", str(tmp_path / "c")]) == 1
    said = capsys.readouterr().err
    assert said.count("has no n") == 4


def test_a_value_that_cannot_be_says_what_to_do(campaign, start, tmp_path, capsys, monkeypatch):
    from pmmkit.base import ModelError

    def refused(*_, **__):
        raise ModelError("aH = -0.5 is outside 0 to 1.")

    monkeypatch.setattr("pmmkit.identification.comparing.identify", refused)
    arguments = ["--model", str(start), "--out", str(tmp_path / "v")]
    assert main(["identify", str(campaign), *arguments]) == 1
    assert "narrower prior" in capsys.readouterr().err


@pytest.mark.slow
def test_a_method_that_fails_beside_others_is_named(records):
    model = pk.load_model(SHIP)
    found = compare_methods(model, records[:2], ["Nv"], methods=("ekf", "sindy"), sensors=NOISE)
    assert tuple(found.found) == ("ekf",)
    assert "2 records are too few" in found.failed["sindy"]
    assert found.errors().empty
    with pytest.raises(DataError, match="2 records are too few"):
        compare_methods(model, records[:2], ["Nv"], methods=("sindy",), sensors=NOISE)
    with pytest.raises(UnknownNameError, match="there are: ekf, ukf"):
        compare_methods(model, records, ["Nv"], methods=("kalman",))
    with pytest.raises(DataError, match="no record"):
        compare_methods(model, [], ["Nv"])
    with pytest.raises(DataError, match="No method succeeded"):
        compare_methods(
            model, records[:2], ["rudder_mmg.aH"], methods=("sindy", "sindy"), sensors=NOISE
        )


@pytest.mark.slow
def test_the_comparison_as_tables(compared):
    found, _ = compared
    frame = found.to_pandas()
    assert list(frame.columns) == ["before", *SECONDS]
    assert frame.loc[("value", "Yv"), "before"] == START["Yv"]
    assert np.isnan(frame.loc[("value", "rudder_mmg.aH"), "sindy"])
    assert (
        frame.loc[("error", "yaw_rate [deg/s]"), "ekf"]
        < frame.loc[("error", "yaw_rate [deg/s]"), "before"]
    )
    assert np.isnan(frame.loc[("seconds", ""), "before"])
    assert list(found.parameters().columns) == COLUMNS
    assert len(found.errors()) == 2 * (1 + len(SECONDS))


@pytest.mark.parametrize("asked", [None, ["Yrvv", "Yvvr", "rudder_mmg.aH", "current_x"]])
def test_parameters_that_are_asked_for(asked):
    model = pk.load_model(SHIP)
    expected = (
        tuple(model.parts["hull_polynomial"].values)
        if asked is None
        else ("Yvvr", "rudder_mmg.aH", "current_x")
    )
    assert parameters_of(model, asked) == expected


def before(prior, spread=None, names=("Yv", "Nv", "rudder_mmg.aH", "current_x"), model=SHIP):
    return known_before(
        pk.load_model(model), names, SPEED, prior=prior, spread=spread, extrapolate=False
    )


def test_the_prior_of_a_table_has_its_values_and_covariance(tmp_path):
    model = pk.load_model(SHIP)
    table = pk.from_values(
        {"Yv": -0.3, "Nv": [-0.13], "Yr": 0.1},
        std={"Yv": 0.02},
        ship=model.ship,
        water=model.water,
        convention=model.convention,
    )
    path = tmp_path / "table.csv"
    pk.write_table(table, path)
    found = before(str(path))
    np.testing.assert_allclose(found.mean, [-0.3, -0.13, 0.312, 0.0])
    np.testing.assert_allclose(found.std, [0.02, 0.3 * 0.13, 0.3 * 0.312, 0.1 * SPEED])
    assert "1 of 2" in found.origin
    assert "of the model itself: rudder_mmg.aH, current_x" in found.origin
    wide = before(str(path), spread=0.1)
    np.testing.assert_allclose(wide.std[:2], [0.03, 0.013])
    with pytest.raises(UnknownNameError, match=r"none of Nvvr; it has Yv, Nv, Yr"):
        before(str(path), names=("Nvvr",))


def test_the_prior_of_another_ship(tmp_path):
    found = before("kvlcc2")
    assert found.mean[0] == pk.load_model("kvlcc2").values("hull_polynomial")["Yv"]
    assert found.origin.startswith("kvlcc2, ")
    # KCS has beta in place of v: converted, a positive Yβ becomes a negative Yv.
    turned = before("kcs", names=("Yv", "Nv"))
    kcs = pk.load_model("kcs").values("hull_polynomial")
    np.testing.assert_allclose(turned.mean, [-kcs["Yv"], -kcs["Nv"]])
    with pytest.raises(UnknownNameError, match="crossflow_drag"):
        before("kvlcc2", names=("crossflow_drag.CD",), model="esso-osaka-3m")


def test_the_prior_of_a_model_has_its_covariance(tmp_path):
    model = pk.load_model(SHIP)
    covariance = np.array([[4e-4, 1e-4], [1e-4, 9e-4]])
    path = tmp_path / "known.toml"
    pk.save_model(model.with_(covariance=covariance, covariance_names=("Yv", "Nv")), path)
    np.testing.assert_allclose(before(str(path)).covariance[:2, :2], covariance)
    np.testing.assert_allclose(before(str(path), spread=0.1).std[0], 0.0315)


@pytest.mark.slow
def test_figures_show_the_numbers_and_give_no_warning(compared, records, tmp_path):
    found, references = compared
    items, filtered = list(found.found.values()), found.found["ekf"].detail
    models = {"before": found.model, "ekf": found.found["ekf"].model}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        figures = {
            "parameters": parameters(items, items[0].model.convention),
            "history": drawings.parameter_histories(filtered, records[:3]),
            "innovations": drawings.innovation_figure(filtered, records[:3], "ZZ20"),
            "window": drawings.window_figure(PredictedWindow.of(models, references, window=50)),
        }
        for name, figure in figures.items():
            assert figure.save(tmp_path / f"{name}.png").stat().st_size > 10_000
    (axis,) = figures["parameters"].axes
    ekf = items[0]
    line = next(line for line in axis.points if line.label == "ekf, 95 %")
    expected = (ekf.values - ekf.prior.mean) / ekf.prior.std
    np.testing.assert_allclose(line.x, expected)
    last = figures["history"].axes[0].points[0].y[-1]
    assert last == pytest.approx(filtered.values[0])
    left, right = figures["window"].axes
    assert left.xlabel.text.endswith("[-]")
    assert right.ylabel.text.endswith("[deg]")
    assert len(figures["innovations"].axes) == 8


@pytest.mark.slow
def test_figures_say_what_is_not_there(compared, records):
    filtered = compared[0].found["ekf"].detail
    with pytest.raises(DataError, match="no result"):
        parameters([], Convention())
    with pytest.raises(UnknownNameError, match="there are Yv"):
        drawings.parameter_histories(filtered, records[:3], names=["Yq"])
    with pytest.raises(UnknownNameError, match="there are ZZ10"):
        drawings.innovation_figure(filtered, records[:3], "spiral")
    with pytest.raises(DataError, match="as long as a window"):
        PredictedWindow.of({"a": compared[0].model}, compared[1], window=1e4)


def of(residuals, gate=math.inf):
    values = np.asarray(residuals, float)[:, None]
    return Innovations(names=("psi",), residuals=values, variances=np.ones_like(values), gate=gate)


WHITE = np.random.default_rng(5).normal(size=3000)


@pytest.mark.parametrize(
    ("residuals", "words"),
    [
        (WHITE, "as large as the filter thinks, and white"),
        (3.1 * WHITE, "psi: innovations are 3.1 times as large as the filter thinks: the model"),
        (0.4 * WHITE, "only 0.4 times as large"),
        (np.convolve(WHITE, np.ones(4) / 2, "same"), "psi: innovations are not white"),
        (WHITE + 0.5, "lean to one side by +0.5"),
    ],
)
def test_consistency_in_words(residuals, words):
    (text,) = Consistency.of({"a": of(residuals)}).words()
    assert words in text


def test_consistency_in_numbers():
    found = Consistency.of({"a": of(WHITE[:1000]), "b": of(WHITE[1000:])})
    whole = found.channels["psi"]
    assert whole.samples == 3000
    assert whole.nis == pytest.approx(np.mean(WHITE**2))
    assert whole.band[0] < 1 < whole.band[1]
    assert found.records["a"]["psi"].samples == 1000
    assert len(found.to_pandas()) == 3
    far = np.where(np.arange(3000) % 20 == 0, 30.0, WHITE)
    gated = Consistency.of({"a": of(far, gate=5.0)})
    assert gated.channels["psi"].gated == pytest.approx(0.05)
    assert "5.0 % of the measurements were not taken in" in " ".join(gated.words())
    assert Consistency.of({"a": of(WHITE[:20])}).words() == ("psi: too few samples to judge.",)
    with pytest.raises(DataError, match="lags"):
        Consistency.of({"a": of(WHITE)}, lags=0)


@pytest.mark.slow
def test_the_whiteness_test_is_right_as_often_as_it_says():
    rng = np.random.default_rng(0)
    small = [
        Consistency.of({"a": of(rng.normal(size=400))}).channels["psi"].p_white < 0.05
        for _ in range(400)
    ]
    assert 0.02 < np.mean(small) < 0.09


def test_gaps_are_left_out_of_correlations():
    series = np.array([1.0, -1.0, np.nan, 1.0, -1.0])
    correlation, pairs = autocorrelation([series, np.array([np.nan])], 3)
    assert pairs.tolist() == [2, 1, 2]
    np.testing.assert_allclose(correlation[0], -1.0)


@pytest.mark.slow
def test_a_filter_on_its_own_model_is_white_and_one_without_process_noise_is_not(records):
    model = pk.load_model(SHIP)
    right = compare_methods(model, records[:2], ["Nv"], methods=("ekf",), sensors=NOISE)
    assert (
        "innovations are as large"
        in " ".join(right.found["ekf"].detail.consistency.words()).lower()
    )
    wrong = model.with_values("hull_polynomial", Yv=-0.15, Nr=-0.1)
    found = compare_methods(
        wrong,
        records[:2],
        ["Nv"],
        methods=("ekf",),
        sensors=NOISE,
        settings={"ekf": {"roughness": 0.0}},
    )
    words = " ".join(found.found["ekf"].detail.consistency.words())
    assert "not white" in words
    assert "times as large" in words
