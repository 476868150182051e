"""Eight drift runs, each setting made twice with 8 N between runs: a comparison, a diagnosis, a
reduction and a report say the same of them whether the campaign file declares them or not."""

from __future__ import annotations

import math

import numpy as np
import pytest
from small_campaign import HEAD, RHO, TRUTH, L

import pmmkit as pk
from pmmkit.cli import main
from pmmkit.reduction import reduce_campaign
from pmmkit.views.report.captive.result_chapters import repeatability

SPEED, BETWEEN = 2.0, 8.0
DRIFTS = (-8.0, -4.0, 4.0, 8.0)


def forces(drift_deg: float) -> dict[str, float]:
    """By Son and Nomoto's derivatives, term by term."""
    v = -math.sin(math.radians(drift_deg))
    unit = 0.5 * RHO * SPEED**2 * L**2
    return {
        name: power * unit * (TRUTH[f"{name}v"] * v + TRUTH[f"{name}vvv"] * v**3)
        for name, power in (("Y", 1.0), ("N", L))
    }


@pytest.fixture(scope="module")
def eight(tmp_path_factory):
    """The campaign as set alike, the same as declared, and the means of its records."""
    folder = tmp_path_factory.mktemp("eight")
    rng = np.random.default_rng(5)
    t = np.arange(0, 20, 0.1)
    entries, means = [], []
    for number, drift in enumerate((*DRIFTS, *DRIFTS)):
        records = [
            force + rng.normal(0, BETWEEN) + rng.normal(0, 1, t.size)
            for force in forces(drift).values()
        ]
        file = folder / f"D{number}.csv"
        np.savetxt(file, np.c_[t, *records], delimiter=",", header="t,Y,N", comments="")
        means.append([record.mean() for record in records])
        entries.append(
            f'[[runs]]\nid = "D{number}"\ntest = "static_drift"\nfile = "D{number}.csv"\n'
            f"speed = {SPEED}\ndrift_deg = {drift}\n"
        )
    first, second = entries[:4], entries[4:]
    stated = [f'{entry}repeat_of = "D{place}"\n' for place, entry in enumerate(second)]
    campaigns = []
    for name, repeats in (("alike", second), ("declared", stated)):
        file = folder / f"{name}.toml"
        file.write_text(
            "\n".join((HEAD, "[columns]\nX = false", *first, *repeats)), encoding="utf-8"
        )
        campaigns.append(pk.open_campaign(file))
    return *campaigns, np.array(means)


def pooled(means) -> dict[str, float]:
    """Of two runs a condition: the root of half the mean square of their differences."""
    size = np.sqrt(np.mean((means[:4] - means[4:]) ** 2, axis=0) / 2)
    return dict(zip("YN", size.tolist(), strict=True))


def test_a_reduction_and_its_report_do_not_ask_whether_repeats_are_declared(eight):
    alike, declared, means = eight
    found = [
        reduce_campaign(each, structure="cubic", executor=1, check=False)
        for each in (alike, declared)
    ]
    for name in ("value", "std"):
        assert np.array_equal(
            getattr(found[0].table, name), getattr(found[1].table, name), equal_nan=True
        )
    chapters = [repeatability(each) for each in found]
    assert chapters[0] == chapters[1]
    kinds = chapters[0].sections[0].tables[0]
    row = dict(zip(kinds.head, kinds.groups[0].rows[0], strict=False))
    assert float(row["Y std [N]"]) == pytest.approx(pooled(means)["Y"], rel=0.005)
    assert float(row["N std [N m]"]) == pytest.approx(pooled(means)["N"], rel=0.005)


def test_a_comparison_holds_what_repeats_scatter_by_in_both(eight):
    """The model is the truth: errors are what runs draw, and U knows it (7 of 8 at 95 %)."""
    alike, declared, means = eight
    truth = pk.load_model("s175-3dof")
    rows = [pk.compare(truth, each, extrapolate=True).to_pandas() for each in (alike, declared)]
    assert rows[0].equals(rows[1])
    side = rows[0][rows[0].channel == "Y"]
    assert (side.uncertainty >= 1.9 * pooled(means)["Y"]).all()
    assert side.within.sum() >= 7


def test_a_diagnosis_gives_one_answer_and_names_nothing(eight):
    alike, declared, _ = eight
    found = [pk.diagnose("cubic", each) for each in (alike, declared)]
    assert found[0].to_dict() == found[1].to_dict()
    assert not found[0].findings
    why = {item.name: item.why for item in found[0].covered}
    assert why["yaw_sway_coupling"] == "these tests do not excite it"
    assert "absorbs" in why["fault_gauge_gain"]


def test_a_few_drift_runs_are_diagnosed_to_the_end(eight, tmp_path):
    """Most effects do nothing in them: those have no columns."""
    file = eight[0].folder / "alike.toml"
    assert main(["diagnose", "cubic", str(file), "--out", str(tmp_path / "d"), "--quiet"]) == 0
    assert (tmp_path / "d" / "report.html").is_file()
