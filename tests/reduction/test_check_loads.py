"""Known weights on the balance: the gains and the point that they tell, and what hangs on them.

A balance is written here by hand: a side load at a station of the model is a moment about the
balance of load times distance, each gauge shows its gain times what it feels and its zero.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
import small_campaign

import pmmkit as pk
from pmmkit.base import CampaignError, ContradictionError
from pmmkit.campaigns import TypeB, load_campaign, save_campaign
from pmmkit.reduction import reduce_campaign

POUND_FEET = 1.3558179483314003
SETS = ((0, 0, 0), (10, 0, 0), (20, 0, 0), (0, 40, 1), (0, 80, 1), (0, -40, 1), (0, 40, -1.2))
"""Surge load [N], side load [N] and its station [m]."""
TABLE = """
[[tables]]
id = "CL_{number}"
test = "check_load"
file = "loads.csv"
"""


def shown(surge, side, arm, *, gain, zero, about):
    """What a balance about a point shows of a load, X, Y and N."""
    felt = {"X": surge, "Y": side, "N": side * (arm - about)}
    return {name: gain.get(name, 1.0) * x + zero.get(name, 0.0) for name, x in felt.items()}


def with_loads(folder, *, gain=None, zero=None, about=0.0, sets=SETS, keys="", noise=0.02):
    """The small campaign with a table of check loads."""
    place = small_campaign.write_campaign(folder)
    rng = np.random.default_rng(7)
    lines = ["number,surge_load,sway_load,load_arm,X,Y,N"]
    for number, (surge, side, arm) in enumerate(sets):
        seen = shown(surge, side, arm, gain=gain or {}, zero=zero or {}, about=about)
        values = [f"{x + noise * rng.normal():.4f}" for x in seen.values()]
        lines.append(",".join([str(number), str(surge), str(side), str(arm), *values]))
    (place / "loads.csv").write_text("\n".join(lines) + "\n")
    file = place / "campaign.toml"
    file.write_text(file.read_text() + TABLE + keys)
    return place


@pytest.fixture(scope="module")
def checked(tmp_path_factory):
    return pk.open_campaign(with_loads(tmp_path_factory.mktemp("right") / "tests"))


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    return pk.open_campaign(small_campaign.write_campaign(tmp_path_factory.mktemp("no") / "tests"))


@pytest.fixture(scope="module")
def reduced(checked, plain):
    return {
        name: reduce_campaign(campaign, executor=1)
        for name, campaign in (("checked", checked), ("plain", plain))
    }


def loads_of(campaign):
    return {item.channel: item for item in campaign.gauge_checks}


def said(campaign):
    return [item for item in pk.examine(campaign) if item.check == "check loads"]


@pytest.mark.slow
def test_check_loads_are_none_of_the_tests(checked, plain, reduced):
    assert len(checked) == len(plain) == 24
    assert [run.id for run in checked.check_loads] == [f"CL_{number}" for number in range(7)]
    assert checked["CL_3"].settings.words == ("Y load +40 N", "at +1 m")
    one, other = (reduced[name].table for name in ("checked", "plain"))
    assert np.array_equal(one.value, other.value)
    assert [item.run.id for item in reduced["checked"].runs] == [run.id for run in plain]


@pytest.mark.slow
def test_a_right_balance_takes_scale_and_point_out_of_the_line(reduced):
    before, after = (reduced[name].verdict for name in ("plain", "checked"))
    assert before.use == after.use == "usable"
    assert str(before).startswith(
        "Usable, if the gauges' scale (X, Y, N), the moments' point (x = "
    )
    assert set(before.conditions) - set(after.conditions) == set(before.conditions[:2])
    assert all("gauges of" not in str(x) for x in reduced["checked"].untold)
    assert reduced["checked"].table.verdict == after


@pytest.mark.slow
def test_the_test_report_tells_the_gains_and_on_what_the_verdict_hangs(reduced, tmp_path):
    from pmmkit.views import captive_document, write_report

    file = write_report(captive_document(reduced["checked"]), tmp_path / "report.html")
    words = " ".join(re.sub("<[^>]*>", " ", Path(file).read_text(encoding="utf-8")).split())
    assert "Check loads on Y: reading over load" in words
    assert "(7 loads, up to 80 N)" in words
    assert "Usable, if the inertia" in words or "Usable, if the gauges" in words


@pytest.mark.slow
def test_what_the_weights_are_uncertain_by_is_in_the_intervals(checked, reduced):
    """A gain that is off by a share takes all derivatives of its channel along by that share."""
    one, other = (reduced[name].table for name in ("checked", "plain"))
    gains = loads_of(checked)
    for name in ("Yv", "Yvdot", "Xuu"):
        column = one.index(name)
        wider = one.std[:, column] ** 2 - other.std[:, column] ** 2
        share = gains[name[0]].std
        assert share == pytest.approx(0.005, rel=0.2)
        assert wider == pytest.approx((share * one[name]) ** 2, rel=0.05), name


def test_what_the_file_states_of_a_gauge_stays(tmp_path):
    keys = '\n[uncertainty]\nY_gauge = [{ std = 1.0, unit = "%", shared = true }]\n'
    campaign = pk.open_campaign(with_loads(tmp_path / "tests", keys=keys)).with_gauges_checked()
    stated = {item.name: item for item in campaign.uncertainty if item.relative}
    assert stated["Y_gauge"] == TypeB(name="Y_gauge", std=0.01, relative=True, shared=True)
    assert stated["N_gauge"].std == pytest.approx(0.005, rel=0.1)


@pytest.mark.slow
def test_moments_in_pound_feet_are_refused_with_their_factor(tmp_path):
    """N as read is in lbf ft: 1 N m shows as 0.7376, and every derivative of N is 26 % small."""
    place = with_loads(tmp_path / "tests", gain={"N": 1 / POUND_FEET}, zero={"N": 3.0})
    campaign = pk.open_campaign(place)
    gain = loads_of(campaign)["N"]
    assert gain.gain * POUND_FEET == pytest.approx(1.0, abs=gain.half)
    assert gain.zero == pytest.approx(3.0, abs=0.1)
    (finding,) = [item for item in said(campaign) if item.severity == "error"]
    assert finding.channels == ("N",)
    assert "readings in lbf ft" in finding.message
    told = float(finding.remedy.rpartition("factor = ")[2].split(",")[0])
    assert told == pytest.approx(POUND_FEET, rel=0.01)
    with pytest.raises(ContradictionError, match=r"N reads 0\.73"):
        reduce_campaign(campaign, executor=1)
    found = reduce_campaign(campaign, executor=1, check=False)
    assert found.verdict.use == "not usable"
    assert found.verdict.conditions[0] == "the gauges' scale (N)"


@pytest.mark.slow
def test_without_a_check_load_pound_feet_are_usable_and_the_line_says_on_what(plain):
    """Nothing in the runs disagrees where every moment is 0.7376 of itself; but 26 % are lost."""

    def in_pound_feet(run):
        data = run.data
        moved = data.assign(N=data.N / POUND_FEET)
        return run.with_(loader=lambda: moved)

    found = reduce_campaign(plain.with_(runs=tuple(map(in_pound_feet, plain))), executor=1)
    column = found.table["Nv"]
    assert column == pytest.approx([small_campaign.TRUTH["Nv"] / POUND_FEET] * 2, rel=0.05)
    assert not found.verdict.faults
    assert "the gauges' scale (X, Y, N)" in str(found.verdict)


def test_its_factor_mends_loads_and_tests_alike(tmp_path, plain):
    """A campaign in pound feet throughout, with the unit of the column stated, is as in N m."""
    place = with_loads(tmp_path / "tests", gain={"N": 1 / POUND_FEET})
    file = place / "campaign.toml"
    file.write_text(file.read_text() + '\n[columns]\nN = { name = "N", unit = "lbf ft" }\n')
    campaign = pk.open_campaign(place)
    assert loads_of(campaign)["N"].agrees
    name = "PS_U1_a0.3"
    ratio = campaign[name].data.N.values / plain[name].data.N.values
    assert ratio == pytest.approx(POUND_FEET, rel=1e-6)


@pytest.mark.slow
def test_a_gain_of_four_per_cent_is_a_warning_and_a_doubt(tmp_path):
    campaign = pk.open_campaign(with_loads(tmp_path / "tests", gain={"Y": 1.04}))
    (finding,) = [item for item in said(campaign) if item.severity != "info"]
    assert (finding.severity, finding.channels) == ("warning", ("Y",))
    found = reduce_campaign(campaign, executor=1)
    assert found.verdict.use == "usable with doubts"
    assert found.verdict.conditions[0] == "the gauges' scale (Y)"
    assert any("Y reads 1.040" in doubt for doubt in found.verdict.doubts)


@pytest.mark.slow
def test_side_loads_at_two_stations_tell_the_point_of_the_moments(tmp_path):
    campaign = pk.open_campaign(with_loads(tmp_path / "tests", about=0.12))
    gain = loads_of(campaign)["N"]
    assert gain.point == pytest.approx(0.12, abs=gain.factor * gain.point_std)
    assert gain.agrees  # the point is fitted beside the gain, and takes nothing of it
    (finding,) = [item for item in said(campaign) if item.severity == "warning"]
    assert finding.remedy.startswith("moment_reference_x = 0.12")
    hidden = reduce_campaign(campaign, executor=1).untold
    assert "moments' point" in {item.name for item in hidden}
    mended = campaign.with_(moment_reference_x=0.12)
    assert [item.severity for item in said(mended)] == ["info"] * 4


def test_at_one_station_gain_and_point_are_one(tmp_path):
    """A side load at 1 m that is felt about 0.1 m has nine tenths of its moment."""
    sets = tuple((surge, side, abs(arm) and 1.0) for surge, side, arm in SETS[:-1])
    campaign = pk.open_campaign(with_loads(tmp_path / "tests", about=0.1, sets=sets))
    gain = loads_of(campaign)["N"]
    assert np.isnan(gain.point)
    assert gain.gain == pytest.approx(0.9, abs=0.01)


def test_a_side_load_without_its_station_says_nothing_of_the_moment(tmp_path):
    place = with_loads(tmp_path / "tests")
    file = place / "loads.csv"
    head, *rows = file.read_text().splitlines()
    columns = [place for place, name in enumerate(head.split(",")) if name != "load_arm"]
    lines = [",".join(np.array(line.split(","))[columns]) for line in (head, *rows)]
    file.write_text("\n".join(lines) + "\n")
    assert {"X", "Y"} == set(loads_of(pk.open_campaign(place)))


def test_records_in_other_axes_with_defaults_of_the_tests(tmp_path):
    """Axes forward, to port and up turn Y and N, of gauges and of loads; no tare is taken."""
    place = small_campaign.write_campaign(tmp_path / "tests")
    rng = np.random.default_rng(3)
    t = np.arange(0.0, 30.0, 0.05)
    text = '\n[axes]\ny = "-y"\nz = "-z"\n[defaults]\nspeed = 1.5\ntare = true\n'
    for number, side in enumerate((0.0, 30.0, 60.0)):
        seen = {"X": 0.0, "Y": 0.97 * side, "N": 0.5 * side}
        columns = [t, *(x + 0.3 * rng.normal(size=t.size) for x in seen.values())]
        name = f"load_{number}.csv"
        np.savetxt(place / name, np.stack(columns, 1), delimiter=",", header="t,X,Y,N", comments="")
        text += (
            f'[[runs]]\nid = "CL_{number}"\ntest = "check_load"\nfile = "{name}"\n'
            f"sway_load = {side}\nload_arm = 0.5\n"
        )
    head, *_ = (place / "campaign.toml").read_text().partition("[[runs]]")
    drift = '[[runs]]\nid = "SD"\ntest = "static_drift"\nfile = "runs/SD_U1_b+08.csv"\n'
    (place / "campaign.toml").write_text(head + text + drift + "drift_deg = 8.0\ntare = false\n")
    campaign = pk.open_campaign(place)
    assert campaign["CL_2"].settings.value("sway_load") == -60.0
    assert [run.settings.speed for run in campaign.check_loads] == [0.0] * 3
    found = loads_of(campaign)
    assert found["Y"].gain == pytest.approx(0.97, abs=0.005)
    assert found["N"].gain == pytest.approx(1.0, abs=0.005)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ("speed = 1.0\nsway_load = 10.0", "leave speed out"),
        ("load_arm = 1.0", "a load that is known"),
    ],
)
def test_what_is_no_check_load_is_refused(tmp_path, keys, message):
    place = small_campaign.write_campaign(tmp_path / "tests")
    file = place / "campaign.toml"
    entry = '\n[[runs]]\nid = "CL"\ntest = "check_load"\nfile = "runs/SD_U1_b+08.csv"\n'
    file.write_text(f"{file.read_text()}{entry}{keys}\n")
    with pytest.raises(CampaignError, match=message):
        pk.open_campaign(place)


def test_a_speed_of_zero_is_that_of_a_check_load(tmp_path):
    place = with_loads(tmp_path / "tests")
    file = place / "campaign.toml"
    file.write_text(file.read_text().replace(TABLE, f"{TABLE}speed = 0.0\n"))
    assert len(pk.open_campaign(place).check_loads) == len(SETS)


@pytest.mark.slow
def test_a_saved_campaign_keeps_them(tmp_path, checked):
    file = tmp_path / "tests.h5"
    save_campaign(checked, file)
    again = load_campaign(file)
    assert [run.id for run in again] == [run.id for run in checked]
    assert again.gauge_checks == checked.gauge_checks
    assert not pk.open_campaign(file, runs=False).check_loads


@pytest.mark.parametrize(
    ("gain", "words"), [({"Y": -1.0}, "Its sign is turned"), ({"Y": 0.0}, "does not feel")]
)
def test_a_turned_and_a_dead_gauge_are_named(tmp_path, gain, words):
    (finding,) = [
        item
        for item in said(pk.open_campaign(with_loads(tmp_path / "tests", gain=gain)))
        if item.severity == "error"
    ]
    assert finding.channels == ("Y",)
    assert words in finding.remedy


def test_corrections_of_all_runs_that_speak_of_motion_mean_the_tests(tmp_path):
    keys = """
[[corrections]]
runs = ["*"]
action = "window"
t_start = 2.0
t_end = 18.0
reason = "steady there"

[[corrections]]
runs = ["*"]
action = "scale"
channels = ["Y"]
factor = 2.0
reason = "half of the bridge was read"
"""
    campaign = pk.open_campaign(with_loads(tmp_path / "tests", keys=keys, gain={"Y": 0.5}))
    assert [item.action for item in campaign["CL_1"].corrections] == ["scale"]
    assert loads_of(campaign)["Y"].agrees


def test_a_check_load_can_be_accepted_or_left_out(tmp_path):
    keys = """
[[corrections]]
runs = ["CL_*"]
action = "accept"
check = "check loads"
reason = "the pulley was seized"

[[corrections]]
runs = ["CL_0"]
action = "exclude"
reason = "the model was touched"
"""
    campaign = pk.open_campaign(with_loads(tmp_path / "tests", keys=keys, gain={"Y": 1.3}))
    assert len(campaign.check_loads) == len(SETS) - 1
    assert {item.severity for item in said(campaign)} == {"info"}
    assert any("the pulley was seized" in item.message for item in said(campaign))


def test_loads_that_scatter_say_nothing(tmp_path):
    """Scatter of ten newtons at forty: the interval would hold pound feet too."""
    campaign = pk.open_campaign(with_loads(tmp_path / "tests", noise=10.0, sets=SETS[:5]))
    gain = loads_of(campaign)["Y"]
    assert gain.half > 0.1
    assert not gain.agrees
    findings = [item for item in said(campaign) if item.channels == ("Y",)]
    assert [item.severity for item in findings] == ["warning"]
    assert "says nothing of its scale" in findings[0].message


def test_check_loads_are_exported_as_csv_and_tell_the_same(checked, tmp_path):
    pk.export(checked, tmp_path / "csv")
    again = pk.open_campaign(tmp_path / "csv")
    assert [run.id for run in again.check_loads] == [run.id for run in checked.check_loads]
    assert again.gauge_checks == checked.gauge_checks
