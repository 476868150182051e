"""SIMMAN archives: what they hold is what the reduction finds, and they come back the same."""

from __future__ import annotations

import csv
import io
import math
import zipfile

import numpy as np
import pytest
import xarray as xr
from small_campaign import write_campaign

import pmmkit as pk
from pmmkit import Campaign, Run
from pmmkit.base import CampaignError, DataError
from pmmkit.campaigns import Settings
from pmmkit.cli import main
from pmmkit.conventions import Ship, Water
from pmmkit.exports.simman.metadata import ASKED
from pmmkit.reduction import PreparedRun

SHIP = Ship(name="model", L=4.0, B=1.0, d=0.25, volume=0.5, mass=500.0, Izz=450.0, xG=0.1)
SPEED, PERIOD, AMPLITUDE, HEADING = 1.2, 8.0, 0.25, 0.2
OMEGA = 2 * math.pi / PERIOD
SAID = {
    "scale": 36.0,
    "turbulence_stimulation": "studs at station 19",
    "water_temperature": 18.6,
    "sample_rate": 20.0,
}


def texts(path):
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name).decode("ascii") for name in archive.namelist()}


def rows(text):
    """The rows of a table by run, numbers where they are."""
    found = {}
    for row in csv.DictReader(io.StringIO(text)):
        found[row["run"]] = {
            title.split(" [")[0]: math.nan if cell == "" else float(cell)
            for title, cell in row.items()
            if title not in ("run", "test")
        }
    return found


def campaign_of(*runs, **said):
    return Campaign(title="Tests", ship=SHIP, water=Water(rho=1000.0), runs=runs, **said)


def oscillating(test, data, forces="hydrodynamic", **settings):
    return Run(
        id=test,
        test=test,
        kind="history",
        settings=Settings(speed=SPEED, period=PERIOD, **settings),
        loader=lambda: data,
        forces=forces,
    )


def history(**channels):
    t = np.arange(0.0, 4 * PERIOD, PERIOD / 400)
    values = {name: ("t", make(OMEGA * t)) for name, make in channels.items()}
    return xr.Dataset(values, coords={"t": t})


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """Two drift angles, a sway and a yaw test of the synthetic S175."""
    folder = write_campaign(tmp_path_factory.mktemp("tests") / "small")
    tests = pk.open_campaign(folder)
    chosen = ("SD_U1_b+04", "SD_U1_b+08", "SD_U1_b+12", "PS_U1_a0.3", "PY_U1_p14", "YD_U1_b8")
    return tests.with_(runs=tuple(tests[name] for name in chosen))


@pytest.fixture(scope="module")
def archive(small, tmp_path_factory):
    path = tmp_path_factory.mktemp("simman") / "small.zip"
    assert pk.export(small, path) == [path]
    return path


def test_pure_sway_of_a_model_with_known_forces(tmp_path):
    """Y = -A v̇ - B v on the water; the balance reads that less m(v̇ + ur), about 0.3 m aft."""
    A, B, arm = 480.0, 90.0, -0.3
    velocity, acceleration = AMPLITUDE * OMEGA, AMPLITUDE * OMEGA**2

    def balance_Y(x):
        vdot = -acceleration * np.sin(x)
        return -A * vdot - B * velocity * np.cos(x) - SHIP.mass * vdot

    data = history(
        X=lambda x: -20.0 + 0 * x,
        Y=balance_Y,
        N=lambda x: 500.0 * 0.1 * acceleration * np.sin(x) - arm * balance_Y(x),
    )
    run = oscillating("pure_sway", data, "balance", amplitude=AMPLITUDE)
    pk.export(campaign_of(run, forces="balance", moment_reference_x=arm), tmp_path / "a.zip")
    found = texts(tmp_path / "a.zip")
    row = rows(found["fourier_coefficients.csv"])["pure_sway"]
    assert row["Y_cos1"] == pytest.approx(-B * velocity, rel=1e-9)
    assert row["Y_sin1"] == pytest.approx(A * acceleration, rel=1e-9)
    assert row["N_sin1"] == pytest.approx(0.0, abs=1e-6)
    assert (row["v_cos1"], row["u_mean"]) == pytest.approx((velocity, SPEED))
    assert (row["period"], row["cycles"]) == (PERIOD, 4)
    cycle = np.genfromtxt(io.StringIO(found["cycles/1_pure_sway.csv"]), delimiter=",", names=True)
    theta = OMEGA * cycle["t_s"]
    assert theta[-1] == pytest.approx(2 * math.pi * (1 - 1 / len(theta)))
    assert cycle["y_m"] == pytest.approx(AMPLITUDE * np.sin(theta), abs=1e-9)
    assert cycle["x_m"] == pytest.approx(SPEED * cycle["t_s"], abs=1e-9)
    water = A * acceleration * np.sin(theta) - B * velocity * np.cos(theta)
    assert cycle["Y_N"] == pytest.approx(water, rel=1e-9, abs=1e-7)
    assert cycle["vdot_ms2"] == pytest.approx(-acceleration * np.sin(theta), abs=1e-9)


def test_the_path_of_a_pure_yaw_test(tmp_path):
    """ψ = ψ0 sin θ along dy/dt = U tan ψ: y is its integral, v is zero."""
    data = history(X=np.cos, Y=np.cos, N=np.sin)
    run = oscillating("pure_yaw", data, yaw_amplitude=HEADING)
    pk.export(campaign_of(run), tmp_path / "a.zip")
    text = texts(tmp_path / "a.zip")["cycles/1_pure_yaw.csv"]
    cycle = np.genfromtxt(io.StringIO(text), delimiter=",", names=True)
    theta = OMEGA * cycle["t_s"]
    assert cycle["psi_rad"] == pytest.approx(HEADING * np.sin(theta), abs=1e-9)
    fine = np.linspace(0.0, 2 * math.pi, 24_001)
    slope = SPEED * np.tan(HEADING * np.sin(fine)) / OMEGA
    path = np.concatenate([[0.0], np.cumsum((slope[1:] + slope[:-1]) / 2 * (fine[1] - fine[0]))])
    path -= path[:-1].mean()
    assert cycle["y_m"] == pytest.approx(np.interp(theta, fine, path), abs=2e-5)
    assert cycle["x_m"] == pytest.approx(SPEED * cycle["t_s"], abs=2e-5)
    assert np.abs(cycle["v_ms"]).max() < 1e-12


def test_results_are_those_of_the_reduction(small, archive):
    found = texts(archive)
    means, waves = rows(found["static_means.csv"]), rows(found["fourier_coefficients.csv"])
    doubts = rows(found["fourier_uncertainties.csv"])
    for run in small:
        result = PreparedRun.of(run, small).result
        for name, values in result.measured.items():
            std = np.sqrt(np.diag(result.covariance[name]))
            if not run.dynamic:
                assert means[run.id][name] == values[0]
                assert means[run.id][f"{name}_std"] == std[0]
                assert means[run.id]["v"] == pytest.approx(-math.sin(run.settings.drift))
                continue
            for place, label in enumerate(result.labels):
                part = f"{'cos' if label[0] == 'C' else 'sin'}{label[1:]}"
                title = f"{name}_{'mean' if label == 'C0' else part}"
                assert waves[run.id][title] == values[place]
                assert doubts[run.id][title] == std[place]
    assert set(means) | set(waves) == {run.id for run in small}


def test_the_cycle_has_the_fourier_coefficients_that_stand_beside_it(archive):
    found = texts(archive)
    waves = rows(found["fourier_coefficients.csv"])
    for name, row in waves.items():
        (file,) = [item for item in found if item.startswith("cycles/") and name in item]
        cycle = np.genfromtxt(io.StringIO(found[file]), delimiter=",", names=True)
        theta = 2 * math.pi * np.arange(len(cycle)) / len(cycle)
        assert cycle["t_s"][1] == pytest.approx(row["period"] / len(cycle))
        for channel, unit in (("X", "N"), ("Y", "N"), ("N", "N_m")):
            force = cycle[f"{channel}_{unit}"]
            assert force.mean() == pytest.approx(row[f"{channel}_mean"], abs=1e-9)
            for order in (1, 2, 5):
                cosine, sine = (2 * np.mean(force * f(order * theta)) for f in (np.cos, np.sin))
                assert cosine == pytest.approx(row[f"{channel}_cos{order}"], abs=1e-9)
                assert sine == pytest.approx(row[f"{channel}_sin{order}"], abs=1e-9)


def test_an_archive_reduces_to_the_same_numbers(small, archive):
    wanted = ["Xuu", "Xvv", "Yv", "Yvvv", "Yvdot", "Nv", "Nvvv", "Nr"]
    one, two = (
        pk.reduce_campaign(tests, structure=wanted, executor=1).table
        for tests in (small, pk.open_campaign(archive))
    )
    assert np.array_equal(one.value, two.value)
    assert np.array_equal(one.std, two.std)


def test_the_tables_alone_are_tests_too(small, archive, tmp_path):
    """Who has no records reads the means and the Fourier coefficients, described from outside."""
    text = (
        (small.folder / "campaign.toml").read_text(encoding="utf-8").split("[[runs]]")[0]
        + f"""
[[tables]]
id = "{{run}}"
test = "static_drift"
file = "{archive.name}"
source = {{ group = "static_means.csv" }}
columns = {{ drift_deg = {{ name = "psi", unit = "rad" }} }}
[[runs]]
id = "sway"
test = "pure_sway"
amplitude_m = 0.3
file = "{archive.name}"
source = {{ group = "fourier_coefficients.csv" }}
row = {{ run = "PS_U1_a0.3" }}
"""
    )
    (tmp_path / "campaign.toml").write_text(text, encoding="utf-8")
    tests = pk.open_campaign(tmp_path, data=archive.parent)
    for run in small.runs[:3]:
        measured = PreparedRun.of(run, small).result.measured
        assert float(tests[run.id].data["Y"]) == measured["Y"][0]
        assert tests[run.id].settings.drift == pytest.approx(run.settings.drift, abs=1e-15)
    values = PreparedRun.of(small["PS_U1_a0.3"], small).result.measured["N"]
    assert tests["sway"].data["N_cos"].values[1] == values[1]
    assert tests["sway"].data["N_sin"].values[1] == values[2]


def test_what_is_missing_is_said_and_nothing_is_made_up(small, tmp_path):
    said = small.with_(title="Modell Süd, λ = 36 試験", report=SAID)
    for name, tests in (("bare", small), ("said", said)):
        pk.export(tests, tmp_path / f"{name}.zip")
    bare = texts(tmp_path / "bare.zip")["metadata.txt"]
    told = texts(tmp_path / "said.zip")["metadata.txt"]
    for letter, (what, key) in ASKED.items():
        missing = f"- {letter}. {what}: not supplied"
        assert (missing in bare) == (key not in ("", "sample_rate"))
        assert (missing in told) == (key != "" and key not in SAID)
        assert (f"as {key} in" in " ".join(told.split())) == (key != "" and key not in SAID)
    assert "1:36" in told
    assert "18.6 deg C" in told
    assert "j. logging frequency: 20 Hz\n" in told
    assert "20 Hz, told from the records" in bare
    assert "mass 454.476 kg, weight 4458.41 N" in told
    assert pk.open_campaign(tmp_path / "said.zip").title == said.title
    assert "Layout of the archive: 1\n" in bare
    assert "Whether a workshop's own programs read them is not known" in " ".join(bare.split())


def test_a_mean_that_is_wrong_and_a_channel_that_is_not_there_stay_empty(tmp_path):
    waves = xr.Dataset(
        {
            "Y_cos": ("harmonic", [0.5, -20.0]),
            "Y_sin": ("harmonic", [0.0, 80.0]),
            "N_cos": ("harmonic", [math.nan, 3.0]),
            "N_sin": ("harmonic", [0.0, math.nan]),
        },
        coords={"harmonic": [0, 1]},
    )
    still = xr.Dataset({"X": ((), -20.0)})
    table = oscillating("pure_sway", waves, amplitude=AMPLITUDE).with_(
        kind="harmonics", use_means=False
    )
    towed = Run(
        id="R", test="resistance", kind="means", settings=Settings(speed=1.0), loader=lambda: still
    )
    recorded = oscillating("pure_yaw", history(X=np.cos, Y=np.cos, N=np.sin), yaw_amplitude=HEADING)
    tests = campaign_of(table, towed, recorded.with_(use_means=False))
    pk.export(tests, tmp_path / "a.zip")
    found = texts(tmp_path / "a.zip")
    row = rows(found["fourier_coefficients.csv"])["pure_sway"]
    assert math.isnan(row["Y_mean"])
    assert math.isnan(row["N_sin1"])
    assert (row["Y_cos1"], row["Y_sin1"], row["N_cos1"]) == (-20.0, 80.0, 3.0)
    assert list(rows(found["static_means.csv"])["R"])[:3] == ["speed", "psi", "X"]
    assert found["cycles/1_pure_yaw.csv"].startswith("t [s],x [m],y [m]")
    said = " ".join(found["metadata.txt"].split())
    assert "No time series: the source is a table of harmonics of pure_sway." in said
    assert "pure_yaw: some coefficients of X, Y, N are not known or known to be wrong" in said
    assert "No times: the source is a table of means of R." in said


def test_free_running_tests_are_time_series_without_fourier_coefficients(tmp_path):
    t = np.arange(0.0, 20.0, 0.1)
    data = xr.Dataset({name: ("t", np.sin(t)) for name in ("x", "y", "psi", "delta")}, {"t": t})
    run = Run(
        id="Z",
        test="zigzag",
        kind="history",
        settings=Settings(speed=1.0, rudder=0.2, switch=0.2),
        loader=lambda: data,
    )
    pk.export(campaign_of(run, kind="free-running"), tmp_path / "a.zip")
    found = texts(tmp_path / "a.zip")
    assert list(found) == ["metadata.txt", "records/1_Z.csv", "records/campaign.toml"]
    assert "a free manoeuvre has no cycle" in found["metadata.txt"]
    again = pk.open_campaign(tmp_path / "a.zip")["Z"].data
    assert np.array_equal(again["psi"], data["psi"])


def test_the_command_writes_and_reads_the_same_to_the_bit(archive, tmp_path, capsys):
    one, two = tmp_path / "a.zip", tmp_path / "b.zip"
    for path in (one, two):
        assert main(["export", str(archive), "--to", "simman", "-o", str(path)]) == 0
    assert one.read_bytes() == two.read_bytes()
    assert str(one) in capsys.readouterr().out
    assert main(["check", str(one), "--json"]) == 0


def test_what_cannot_be_handed_in_is_refused_whole(small, tmp_path):
    with pytest.raises(DataError, match=r"needs the ending \.zip"):
        pk.export(small, tmp_path / "a.txt", "simman")
    short = small["PS_U1_a0.3"].data.isel(t=slice(0, 100))
    runs = [small["PS_U1_a0.3"].with_(id=name, loader=lambda: short) for name in ("one", "two")]
    with pytest.raises(CampaignError, match="has no results to hand in") as caught:
        pk.export(small.with_(runs=tuple(runs)), tmp_path / "a.zip")
    assert {problem.run for problem in caught.value.problems} == {"one", "two"}
    assert list(tmp_path.iterdir()) == []
