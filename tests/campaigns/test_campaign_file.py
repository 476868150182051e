"""The campaign file: every key means what it says, in SI and with our signs."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from pmmkit import open_campaign
from pmmkit.base import CampaignError
from tests.support.small_campaign import SHIP

HEAD = f"""[campaign]
title = "t"
kind = "captive"
forces = "hydrodynamic"
{{campaign}}
{SHIP}[water]
rho = 999.1
g = 9.81
"""
T = np.arange(60) * 0.1


@pytest.fixture
def write(tmp_path):
    """Write a campaign of one run; gives the campaign as read."""

    def _write(runs, *, campaign="", more="", files=None, encoding="utf-8", data=None):
        for name, text in (files or {}).items():
            path = tmp_path / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(text if isinstance(text, bytes) else text.encode(encoding))
        text = HEAD.format(campaign=campaign) + more + runs
        (tmp_path / "campaign.toml").write_text(text, encoding="utf-8")
        return open_campaign(tmp_path, data=data)

    return _write


def csv(columns, delimiter=",", decimal="."):
    """CSV text of columns by header."""
    lines = [delimiter.join(columns)]
    for row in zip(*columns.values(), strict=True):
        lines.append(delimiter.join(f"{x:.6f}".replace(".", decimal) for x in row))
    return "\n".join(lines) + "\n"


def plain(**scale):
    return {"t": T, **{name: np.full(len(T), value) for name, value in scale.items()}}


DRIFT = '[[runs]]\nid = "a"\ntest = "static_drift"\nfile = "a.csv"\nspeed = 1.0\ndrift_deg = 8.0\n'


def test_settings_are_si_and_radians(write):
    runs = (
        '[[runs]]\nid = "PS"\ntest = "pure_sway"\nfile = "a.csv"\nspeed = 1.0\nperiod = 12.5\n'
        "amplitude_m = 0.2\nphase_deg = 90.0\n"
        '[[runs]]\nid = "YD"\ntest = "yaw_drift"\nfile = "a.csv"\nspeed = 1.0\nperiod = 12.5\n'
        "yaw_amplitude_deg = 8.0\ndrift_deg = 4.0\n"
    )
    made = write(runs, files={"a.csv": csv(plain(X=1, Y=2, N=3))})
    assert made["PS"].settings.phase == pytest.approx(math.pi / 2)
    assert made["PS"].settings.amplitude == 0.2
    assert made["YD"].settings.yaw_amplitude == pytest.approx(math.radians(8))
    assert made["YD"].settings.drift == pytest.approx(math.radians(4))
    assert made["PS"].settings.omega == pytest.approx(2 * math.pi / 12.5)
    assert made.ship.froude(1.0) == pytest.approx(0.1448, abs=1e-4)


def test_units_in_headers_convert_and_are_recorded(write):
    columns = {
        "t [s]": T,
        "X [kN]": 0 * T + 0.5,
        "Y (N)": 0 * T + 2.0,
        "N [kN m]": 0 * T + 0.3,
        "delta [deg]": 0 * T + 10.0,
    }
    data = write(DRIFT, files={"a.csv": csv(columns)})["a"].data
    assert data["X"].values[0] == pytest.approx(500.0)
    assert data["N"].values[0] == pytest.approx(300.0)
    assert data["delta"].values[0] == pytest.approx(math.radians(10))
    assert data["X"].attrs["units"] == "N"
    assert any("kN" in step for step in json.loads(data.attrs["conversions"]))


@pytest.mark.parametrize(
    ("delimiter", "decimal", "encoding"),
    [(",", ".", "utf-8"), (";", ",", "utf-8-sig"), ("\t", ".", "utf-8"), (" ", ".", "utf-8")],
)
def test_layouts_of_text_are_found(write, delimiter, decimal, encoding):
    text = csv(plain(X=-1.5, Y=2.25, N=3.0), delimiter, decimal)
    for ends in ("\n", "\r\n"):
        made = write(DRIFT, files={"a.csv": text.replace("\n", ends)}, encoding=encoding)
        assert made["a"].data["Y"].values == pytest.approx(2.25)
        assert made["a"].data.sizes["t"] == len(T)


def test_columns_by_name_and_by_number_below_a_header(write):
    body = "Tank 7, 3.4.1998, Größe\nsecond line\n" + csv(
        {"Time": T, "F1": 0 * T + 5, "F2": 0 * T + 7, "Mz": 0 * T + 9}
    )
    more = (
        '[source]\nskip_rows = 2\nencoding = "cp1252"\n[columns]\nt = "Time"\n'
        'X = { column = 2, unit = "kgf" }\nY = { name = "F2", scale = -1.0 }\nN = "Mz"\n'
    )
    data = write(DRIFT, more=more, files={"a.csv": body.encode("cp1252")})["a"].data
    assert data["X"].values[0] == pytest.approx(5 * 9.80665)
    assert data["Y"].values[0] == -7
    assert data["N"].values[0] == 9


def test_signs_and_axes_of_the_source(write):
    """Port rudder positive, port-bow drift positive, axes turned by half a turn about z."""
    made = write(
        DRIFT + "rudder_deg = 5.0\n",
        campaign='rudder_positive = "port"\ndrift_positive = "port-bow"',
        more='[axes]\nx = "-x"\ny = "-y"\n',
        files={"a.csv": csv(plain(X=1, Y=2, N=3, delta=0.1))},
    )
    run = made["a"]
    assert run.settings.drift == pytest.approx(-math.radians(8))
    assert run.settings.rudder == pytest.approx(-math.radians(5))
    data = run.data
    found = [data[name].values[0] for name in ("X", "Y", "N", "delta")]
    assert found == pytest.approx([-1, -2, 3, -0.1])


def test_y_to_port_turns_moment_and_yaw_rate_too(write):
    made = write(
        DRIFT, more='[axes]\ny = "-y"\n', files={"a.csv": csv(plain(X=1, Y=2, N=3, r=0.1, v=0.2))}
    )
    data = made["a"].data
    found = [data[name].values[0] for name in ("X", "Y", "N", "r", "v")]
    assert found == pytest.approx([1, -2, -3, -0.1, -0.2])


def test_rows_of_a_table_of_means_in_prime_units(write):
    table = "Run No.,beta,X',Y'\n12,8,-0.0005,0.002\n13,-8,-0.0005,-0.002\n"
    more = '[source]\nnondimensional = "prime"\n[columns]\nX = "X\'"\nY = "Y\'"\n'
    run = DRIFT.replace('file = "a.csv"', 'file = "a.csv"\nrow = { "Run No." = 12 }')
    made = write(run, more=more, files={"a.csv": table})
    assert made["a"].kind == "means"
    unit = 0.5 * 999.1 * 4.861111**2
    assert float(made["a"].data["Y"]) == pytest.approx(0.002 * unit)


def test_a_table_whose_rows_are_harmonics(write):
    """In phase with the displacement is the sine, out of phase the cosine; amplitudes in prime."""
    table = "No,f,vdot,Y_mean,Y_in,Y_out\n7,0.05,-0.1,0.001,0.004,-0.003\n"
    tables = (
        '[[tables]]\nid = "PS_{No}"\ntest = "pure_sway"\nfile = "a.csv"\nspeed = 1.0\n'
        '[tables.columns]\nfrequency_hz = "f"\nvdot_amplitude = "vdot"\nY_mean = "Y_mean"\n'
        'Y_in1 = "Y_in"\nY_out1 = "Y_out"\n'
    )
    more = '[source]\nnondimensional = "prime"\nin_phase_with = "displacement"\n'
    run = write(tables, more=more, files={"a.csv": table})["PS_7"]
    unit, omega = 0.5 * 999.1 * 4.861111**2, 2 * math.pi * 0.05
    assert run.kind == "harmonics"
    assert run.settings.amplitude == pytest.approx(0.1 / 4.861111 / omega**2)
    data = run.data
    assert data["Y_sin"].values[1] == pytest.approx(0.004 * unit)
    assert data["Y_cos"].values[:2] == pytest.approx([0.001 * unit, -0.003 * unit])
    assert run.stated["vdot_amplitude"] == pytest.approx(-0.1)


def test_corrections_act_and_keep_their_reason(write):
    runs = DRIFT + DRIFT.replace('id = "a"', 'id = "b"') + DRIFT.replace('id = "a"', 'id = "c"')
    more = (
        '[[corrections]]\nruns = ["c"]\naction = "exclude"\nreason = "copy of b"\n'
        '[[corrections]]\nruns = ["a", "b"]\naction = "scale"\nchannels = ["Y"]\nfactor = 2.0\n'
        'reason = "gauge calibrated with half the weight"\n'
        '[[corrections]]\nruns = ["b"]\naction = "inertia still inside"\nreason = "seen in sway"\n'
    )
    made = write(runs, more=more, files={"a.csv": csv(plain(X=1, Y=2, N=3))})
    assert [run.id for run in made] == ["a", "b"]
    assert made.excluded[0][1] == "copy of b"
    assert made["a"].data["Y"].values[0] == 4
    assert made["b"].forces == "balance"
    assert made["a"].corrections[0].reason.startswith("gauge")


def test_stated_uncertainties(write):
    more = (
        '[uncertainty]\nX_gauge = { std = 0.1, unit = "N", shared = true }\ndrift_deg = 0.03\n'
        'speed = 0.002\nY_gauge = [{ std = 0.2, unit = "N" }, { std = 0.5, unit = "%" }]\n'
    )
    made = write(DRIFT, more=more, files={"a.csv": csv(plain(X=1, Y=2, N=3))})
    found = {(b.name, b.relative): (b.std, b.shared) for b in made.uncertainty}
    assert found["X_gauge", False] == (0.1, True)
    assert found["drift", False] == (pytest.approx(math.radians(0.03)), False)
    assert found["speed", False] == (0.002, False)
    assert found["Y_gauge", True] == (pytest.approx(0.005), False)


def test_data_elsewhere_is_named_by_argument_or_environment(write, tmp_path_factory, monkeypatch):
    store = tmp_path_factory.mktemp("store")
    (store / "lab").mkdir()
    (store / "lab" / "a.csv").write_text(csv(plain(X=1, Y=2, N=3)))
    campaign = 'data_folder = "lab"'
    assert write(DRIFT, campaign=campaign, data=store)["a"].data["N"].values[0] == 3
    with pytest.raises(CampaignError, match="PMMKIT_DATA"):
        write(DRIFT, campaign=campaign)
    monkeypatch.setenv("PMMKIT_DATA", str(store))
    assert write(DRIFT, campaign=campaign)["a"].data["N"].values[0] == 3


def test_a_library_ship_by_name_alone(write, tmp_path):
    write(DRIFT, files={"a.csv": csv(plain(X=1, Y=2, N=3))})
    text = (tmp_path / "campaign.toml").read_text(encoding="utf-8")
    start, stop = text.index("[ship]"), text.index("[water]")
    (tmp_path / "campaign.toml").write_text(
        text[:start] + '[ship]\nname = "s175"\n' + text[stop:], encoding="utf-8"
    )
    assert open_campaign(tmp_path).ship.L == 175.0


def test_missing_settings_of_a_test_are_named(write):
    runs = '[[runs]]\nid = "p"\ntest = "pure_yaw"\nfile = "a.csv"\nspeed = 1.0\n'
    with pytest.raises(CampaignError) as caught:
        write(runs, files={"a.csv": csv(plain(X=1, Y=2, N=3))})
    assert "period" in str(caught.value)
    assert "yaw_amplitude_deg" in str(caught.value)
