"""What lies in a folder twice counts once: saved copies, sheets that share runs, two issues."""

from __future__ import annotations

import tomllib
from collections import Counter
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pmmkit.campaigns import campaign_of
from pmmkit.intake import campaign_draft, written

RNG = np.random.default_rng(7)
DRIFT = np.arange(-16.0, 17.0, 2.0)


def forces(drift: np.ndarray, rudder: np.ndarray, noise: float = 0.0) -> dict[str, np.ndarray]:
    """Forces of a hull of 4 m at 1.2 m/s, and her rudder's; noise over the rms of each."""
    v = np.sin(np.radians(drift))
    delta = np.radians(rudder)
    exact = {
        "X [N]": -9.0 - 6.0 * v**2 - 3.0 * delta**2,
        "Y [N]": 140.0 * v + 300.0 * v**3 - 11.0 * delta,
        "N [Nm]": 120.0 * v - 60.0 * v**3 + 21.0 * delta,
    }
    return {
        name: x + noise * np.sqrt(np.mean(x**2)) * RNG.standard_normal(len(x))
        for name, x in exact.items()
    }


def table(
    drift: np.ndarray, rudder: float = 0.0, noise: float = 0.01, name: str = "T"
) -> pd.DataFrame:
    settings = {
        "Run": [f"{name}{k:02d}" for k in range(len(drift))],
        "speed [m/s]": np.full(len(drift), 1.2),
        "drift [deg]": drift,
        "rudder [deg]": np.full(len(drift), rudder),
    }
    return pd.DataFrame({**settings, **forces(drift, np.full(len(drift), rudder), noise)})


def drafted(folder: Path) -> tuple[dict, tuple[str, ...]]:
    draft = campaign_draft(folder, folder / "campaign.toml")
    return tomllib.loads(written(draft).text), draft.repeated


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    own = tmp_path / "tests"
    own.mkdir()
    return own


def test_a_sheet_saved_as_text_counts_once(folder: Path) -> None:
    measured = table(DRIFT)
    measured.to_excel(folder / "drift.xlsx", sheet_name="static drift", index=False)
    measured.to_csv(folder / "static_drift.csv", index=False)
    raw, repeated = drafted(folder)
    assert [entry["file"] for entry in raw["tables"]] == ["drift.xlsx"]
    assert repeated == ("static_drift.csv",)


def test_runs_that_two_sheets_list_are_taken_from_one(folder: Path) -> None:
    straight, turned = table(DRIFT, name="A"), table(DRIFT, rudder=20.0, name="B")
    with pd.ExcelWriter(folder / "programme.xlsx") as book:
        straight.to_excel(book, sheet_name="static drift", index=False)
        both = pd.concat([straight, turned])
        both.to_excel(book, sheet_name="drift and rudder", index=False)
    raw, repeated = drafted(folder)
    first, second = raw["tables"]
    assert not repeated
    assert "skip" not in first
    assert second["skip"] == list(range(2, 2 + len(DRIFT)))


@pytest.mark.parametrize("noise", [0.005, 0.02])
def test_a_programme_measured_again_stays(folder: Path, noise: float) -> None:
    for day in ("first", "second"):
        table(DRIFT, noise=noise).to_csv(folder / f"static_drift_{day}.csv", index=False)
    raw, repeated = drafted(folder)
    assert len(raw["tables"]) == 2
    assert not repeated


def test_of_two_issues_the_finer_is_taken(folder: Path) -> None:
    measured = table(DRIFT).round({"X [N]": 4, "Y [N]": 4, "N [Nm]": 4})
    coarse = measured.round({"Y [N]": 2, "N [Nm]": 2})
    coarse["X [N]"] = (coarse["X [N]"] + 0.4).round(2)
    coarse.to_csv(folder / "static_drift_2014.csv", index=False)
    measured.to_csv(folder / "static_drift_2012.csv", index=False)
    raw, repeated = drafted(folder)
    assert [entry["file"] for entry in raw["tables"]] == ["static_drift_2012.csv"]
    assert repeated == ("static_drift_2014.csv",)


def test_a_list_that_has_its_runs_in_two_series_counts_them_once(folder: Path) -> None:
    """One list of all series: straight drift stands among drift alone and with rudder."""
    straight, turned = table(DRIFT), table(DRIFT, rudder=10.0, name="R")
    alone = straight.assign(series="drift angle")
    beside = pd.concat([straight, turned]).assign(series="drift and rudder")
    pd.concat([alone, beside]).to_csv(folder / "captive.csv", index=False)
    raw, repeated = drafted(folder)
    (entry,) = raw["tables"]
    assert repeated == ()
    assert len(entry["skip"]) == len(DRIFT)
    again = 2 + len(DRIFT)  # the names, then the rows that stand there first
    assert entry["skip"] == [*range(again, again + len(DRIFT))]


def test_rows_of_a_coarse_balance_are_no_copies(folder: Path) -> None:
    """Whole newtons meet by chance: two days of a small model are two days."""
    for day in ("first", "second"):
        rough = table(DRIFT, noise=0.05)
        rough[["X [N]", "Y [N]", "N [Nm]"]] = (rough[["X [N]", "Y [N]", "N [Nm]"]] / 20).round()
        rough.to_csv(folder / f"static_drift_{day}.csv", index=False)
    raw, _ = drafted(folder)
    assert len(raw["tables"]) == 2
    assert all("skip" not in entry for entry in raw["tables"])


def of_laboratory(shared_data: Path, name: str) -> Path:
    folder = shared_data / name
    if not folder.is_dir():
        pytest.skip(f"the measurements of {name} are not here")
    return folder


def test_hmri_workbook_and_its_exports(shared_data: Path, tmp_path: Path) -> None:
    """Sheets that share 17 and 6 runs, and exports of them all: each run counts once."""
    folder = of_laboratory(shared_data, "kvlcc2_hmri_pmm")
    target = tmp_path / "campaign.toml"
    draft = campaign_draft(folder, target)
    assert {"pure_sway.csv", "pure_yaw.csv", "yaw_drift.csv"} <= {*draft.repeated}
    assert {"static_drift.csv", "static_rudder.csv"} <= {*draft.repeated}
    raw = tomllib.loads(written(draft).text)
    usual = {"nondimensional": "prime", "in_phase_with": "displacement"}
    assert raw["defaults"]["source"] == usual
    campaign = campaign_of(raw, target)
    measured = Counter(run.test for run in campaign)
    assert measured["pure_sway"] == 4
    assert measured["pure_yaw"] == 6
    assert measured["yaw_drift"] == 22 - 6
    assert measured["static_drift"] == 18


def test_the_first_issue_of_the_kcs_is_left_out(shared_data: Path, tmp_path: Path) -> None:
    draft = campaign_draft(
        of_laboratory(shared_data, "kcs_fhr_shallow"), tmp_path / "campaign.toml"
    )
    assert {Path(entry.file).name[:5] for entry in draft.tables} == {"App01"}
    assert [name[:5] for name in draft.repeated] == ["App06"] * 3
