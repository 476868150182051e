"""The captive tests of KVLCC2 at HMRI: refused as published, accepted as they are.

The measurements are not part of the repository; these tests skip without them.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from pmmkit import Campaign, open_campaign
from pmmkit.base import ContradictionError
from pmmkit.intake import CheckFinding, Untold, examine, refuse

Findings = tuple[CheckFinding, ...]


@pytest.fixture(scope="module")
def published(shared_data: Path, datasets: Path) -> Campaign:
    if not (shared_data / "kvlcc2_hmri_pmm").is_dir():
        pytest.skip("the HMRI measurements are not on this machine")
    return open_campaign(datasets / "kvlcc2_hmri" / "as_published.toml", data=shared_data)


@pytest.fixture(scope="module")
def refused(published: Campaign) -> Findings:
    return examine(published)


@pytest.fixture(scope="module")
def accepted(shared_data: Path, datasets: Path, published: Campaign) -> Findings:
    return examine(open_campaign(datasets / "kvlcc2_hmri", data=shared_data))


def test_what_these_tests_cannot_tell_is_said_by_their_settings(published: Campaign) -> None:
    told = {item.name: item for item in Untold.of(published)}
    assert told["scale"].condition == "the gauges' scale (X, Y, N)"
    assert told["moments' point"].condition.startswith("the moments' point (x = ")
    assert "the kind of test" in told["day"].text
    assert not {"one speed", "one frequency", "side"} & set(told)


def of(findings: Findings, check: str, text: str = "") -> CheckFinding:
    (found,) = [item for item in findings if item.check == check and text in item.message]
    return found


def test_the_published_description_is_refused_with_everything_at_once(refused):
    with pytest.raises(ContradictionError) as raised:
        refuse(refused)
    text = str(raised.value)
    for check in (
        "inertia",
        "signs",
        "means",
        "copies",
        "length",
        "open water",
        "moment reference",
    ):
        assert f"[{check}]" in text


def test_inertia_is_inside_Y_N_X_and_Yr(refused):
    found = [item for item in refused if item.check == "inertia"]
    assert len(found) == 4
    for item in found:
        assert "still inside" in item.message
        assert 0.8 < item.numbers["share_of_inertia"] < 1.2


def test_the_means_are_on_other_scales(refused):
    assert of(refused, "means", "static T").numbers["T_pure_sway"] == pytest.approx(39.8, abs=0.1)
    assert of(refused, "means", "static T").numbers["T_yaw_drift"] == pytest.approx(102, abs=1)
    assert 30 < of(refused, "means", "static Y").numbers["Y_yaw_drift"] < 35
    assert "not one constant" in of(refused, "means", "static Y").message


def test_the_copy_of_run_279(refused):
    found = [item for item in refused if item.check == "copies" and item.severity == "error"]
    assert [item.runs for item in found] == [("YD_279_b12", "YD_279_b16")]


def test_the_phase_of_run_380(refused):
    found = of(refused, "sister runs")
    assert found.runs == ("PY_380",)
    assert found.numbers["ratio"] == pytest.approx(-0.0056, abs=1e-4)


def test_the_rudder_is_positive_to_port(refused):
    found = [item for item in refused if item.check == "signs"]
    assert len(found) == 2
    assert all('rudder_positive = "port"' in item.remedy for item in found)


def test_the_length_is_320_m_over_the_scale(refused):
    found = of(refused, "length")
    assert found.numbers["length"] == pytest.approx(320 / 46.426, rel=1e-4)
    assert found.numbers["block"] == pytest.approx(0.8098, abs=3e-4)


def test_the_moments_refer_to_the_centre_of_gravity(refused):
    found = of(refused, "moment reference", "mass matrix")
    assert found.severity == "error"
    assert abs(found.numbers["x_over_L"] - 0.035) < 0.005
    assert found.numbers["x"] > 6 * found.numbers["std"]


def test_the_open_water_table_holds_100_KQ(refused):
    assert of(refused, "open water").numbers["factor"] == 100


def test_the_rudder_areas_are_exchanged(refused):
    found = of(refused, "particulars", "rudder area")
    assert found.numbers["movable"] == pytest.approx(136.7 / 46.426**2, rel=1e-3)
    assert found.numbers["lateral"] == pytest.approx(112.5 / 46.426**2, rel=3e-3)


def test_columns_in_phase_taken_with_the_velocity_are_refused(
    published: Campaign, shared_data: Path, datasets: Path, tmp_path: Path
):
    text = (datasets / "kvlcc2_hmri" / "campaign.toml").read_text(encoding="utf-8")
    wrong = text.replace('in_phase_with = "displacement"', 'in_phase_with = "velocity"')
    assert wrong != text
    (tmp_path / "campaign.toml").write_text(wrong, encoding="utf-8")
    findings = examine(open_campaign(tmp_path, data=shared_data))
    assert any(item.check == "inertia" and "neither" in item.message for item in findings)
    with pytest.raises(ContradictionError):
        refuse(findings)


def test_the_true_description_has_no_error(accepted):
    refuse(accepted)
    assert {item.check for item in accepted if item.severity == "warning"} <= {
        "moment reference",
        "sister runs",
        "agreement",
    }
