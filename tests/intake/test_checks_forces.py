"""Checks of what the forces say: inertia, signs, sizes, means, moment point, the two sides."""

from __future__ import annotations

import math
import shutil

import numpy as np
import pytest
import xarray as xr
from checks_programme import HULL, SHIP, WATER, campaign_of, programme, run_of

from pmmkit import Run, open_campaign
from pmmkit.base import ContradictionError
from pmmkit.campaigns import Settings
from pmmkit.intake import CheckFinding, campaign_draft, examine, refuse, summarise, written
from pmmkit.intake.checks import CHECKS


def said(findings, check: str) -> list[CheckFinding]:
    return [finding for finding in findings if finding.check == check]


def scaled(**factors):
    """A change that multiplies channels."""

    def change(run: Run, data: xr.Dataset) -> xr.Dataset:
        return data.assign({name: data[name] * factor for name, factor in factors.items()})

    return change


@pytest.fixture(scope="module")
def clean() -> tuple[CheckFinding, ...]:
    return examine(campaign_of(programme(noise=0.05)))


@pytest.mark.slow
def test_a_clean_bare_hull_programme_draws_no_error_and_no_warning(clean):
    assert [str(finding) for finding in clean if finding.severity != "info"] == []
    refuse(clean)


def test_a_clean_programme_with_the_inertia_inside_and_so_stated_is_silent_too():
    runs = programme(speeds=(1.5,), inside=True, forces_are="balance", noise=0.05)
    findings = examine(campaign_of(runs, forces="balance"))
    assert [str(finding) for finding in findings if finding.severity != "info"] == []


@pytest.mark.slow
@pytest.mark.parametrize(
    ("inside", "claim", "words"),
    [(True, "hydrodynamic", "still inside"), (False, "balance", "already removed")],
)
def test_a_wrong_claim_about_inertia_is_told_in_each_of_Y_N_X_and_Yr(inside, claim, words):
    runs = programme(speeds=(1.5,), inside=inside, forces_are=claim)
    found = said(examine(campaign_of(runs, forces=claim)), "inertia")
    assert len(found) == 4
    assert all(finding.severity == "error" and words in finding.message for finding in found)
    starts = sorted(finding.message.split(" ")[0] for finding in found)
    assert starts == ["N", "X", "Y", "Y"]
    assert "fits them all" in found[0].message


@pytest.mark.slow
def test_the_measured_ratios_are_the_masses_that_were_put_in():
    runs = programme(speeds=(1.0, 2.0), inside=True, noise=0.0)
    found = said(examine(campaign_of(runs)), "inertia")
    unit = 0.5 * WATER.rho * SHIP.L**3
    ratios = [finding.numbers["ratio"] for finding in found]
    expected = [
        -(SHIP.mass + HULL["my"] * unit),
        -(SHIP.Izz + HULL["Jz"] * unit * SHIP.L**2),
        None,
        -(SHIP.mass + HULL["mx"] * unit),
    ]
    for ratio, value in zip(ratios, expected, strict=True):
        assert value is None or ratio == pytest.approx(value, rel=2e-3)


def test_inertia_left_in_one_channel_only_is_told_as_such():
    runs = [
        run_of(f"PY_{angle}", "pure_yaw", period=13.2, yaw_amplitude=math.radians(angle))
        for angle in (4, 8, 12)
    ]
    heavy = [
        run_of(
            f"PY_{angle}", "pure_yaw", period=13.2, yaw_amplitude=math.radians(angle), inside=True
        )
        for angle in (4, 8, 12)
    ]
    mixed = [
        run.with_(loader=lambda a=run, b=other: a.data.assign(N=b.data["N"]))
        for run, other in zip(runs, heavy, strict=True)
    ]
    found = said(examine(campaign_of(mixed)), "inertia")
    assert len(found) == 1
    assert found[0].message.startswith("N in phase")
    assert "The reverse is seen in Yr, X" in found[0].message


def test_in_phase_and_out_of_phase_exchanged_is_neither_claim():
    def exchanged(run, data):
        if run.test != "pure_sway":
            return data
        shift = round(run.settings.period / 4 / 0.1)
        return data.assign(Y=("t", np.roll(data["Y"].values, shift)))

    found = examine(campaign_of(programme(speeds=(1.5,), change=exchanged)))
    assert any("neither" in finding.message for finding in said(found, "inertia"))


@pytest.mark.parametrize("draughts", [1.3, 2.0])
def test_a_false_claim_is_told_in_shallow_water_too(draughts):
    """Y over r u holds the mass whatever the bottom adds; a right claim is left alone."""
    water = WATER.__class__(rho=999.1, depth=draughts * SHIP.d)
    inside = programme(speeds=(1.5,), inside=True)
    found = said(examine(campaign_of(inside, water=water)), "inertia")
    assert found[0].severity == "error"
    assert any("over r u" in finding.message for finding in found)
    right = [run.with_(forces="balance") for run in inside]
    assert said(examine(campaign_of(right, water=water)), "inertia") == []


def flipped_drift(run: Run) -> Run:
    return run.with_(settings=Settings(**{**vars(run.settings), "drift": -run.settings.drift}))


def test_drift_counted_to_the_other_side_is_mended_by_drift_positive():
    runs = [flipped_drift(run) for run in programme(speeds=(1.5,)) if run.test == "static_drift"]
    found = said(examine(campaign_of(runs)), "signs")
    assert len(found) == 2
    assert all('drift_positive = "port-bow"' in finding.remedy for finding in found)
    assert all(finding.numbers["slope"] < 0 for finding in found)


def test_a_moment_of_the_wrong_sign_alone_is_not_blamed_on_drift():
    runs = programme(speeds=(1.5,), change=scaled(N=-1.0))
    found = said(examine(campaign_of(runs)), "signs")
    assert {finding.message[:2] for finding in found} >= {"N'", "Nv", "Nr"}
    assert "flip" in found[0].remedy
    assert not any(finding.message.startswith("Y'") for finding in found)


def rudder_runs(sign: float, lever: float = -0.49) -> list[Run]:
    runs = []
    unit = 0.5 * WATER.rho * SHIP.L**2 * 1.5**2
    for degrees in (-20, -10, -5, 0, 5, 10, 20):
        Y = -0.003 * math.radians(degrees) * sign * unit + 0.2 * math.sin(degrees)
        data = xr.Dataset({"X": -20.0 - 0.01 * degrees**2, "Y": Y, "N": Y * lever * SHIP.L})
        runs.append(
            Run(
                id=f"SR_{degrees}",
                test="static_rudder",
                kind="means",
                loader=lambda d=data: d,
                settings=Settings(speed=1.5, rudder=math.radians(degrees), propeller_rps=8.0),
            )
        )
    return runs


def test_rudder_signs():
    assert said(examine(campaign_of(rudder_runs(1.0))), "signs") == []
    found = said(examine(campaign_of(rudder_runs(-1.0))), "signs")
    assert len(found) == 2
    assert all('rudder_positive = "port"' in finding.remedy for finding in found)


def test_a_rudder_cannot_act_aft_of_the_stern():
    assert said(examine(campaign_of(rudder_runs(1.0))), "moment reference") == []
    (found,) = said(examine(campaign_of(rudder_runs(1.0, -0.6))), "moment reference")
    assert found.numbers["lever_over_L"] == pytest.approx(-0.6, abs=1e-6)
    stated = campaign_of(rudder_runs(1.0, -0.6), moment_reference_x=0.1 * SHIP.L)
    assert said(examine(stated), "moment reference") == []


def test_resistance_that_pushes():
    runs = [
        run_of(f"R_{speed}", "resistance", speed=speed, propeller_rps=0.0, change=scaled(X=sign))
        for speed, sign in ((1.0, -1.0), (1.5, -1.0), (2.0, -1.0))
    ]
    (found,) = said(examine(campaign_of(runs)), "signs")
    assert "X is positive in 3 of 3 runs" in found.message
    right = [run_of(f"R_{speed}", "resistance", speed=speed) for speed in (1.0, 1.5, 2.0)]
    assert said(examine(campaign_of(right)), "signs") == []


@pytest.mark.slow
@pytest.mark.parametrize(
    ("factor", "word"),
    [
        (9.80665, "kilogram-force"),
        (1 / 9.80665, "kilogram-force"),
        (1000.0, "1000"),
        (SHIP.L / SHIP.d, "L/d"),
    ],
)
def test_forces_off_by_a_round_factor_are_told_with_the_factor(factor, word):
    runs = programme(speeds=(1.5,), change=scaled(X=factor, Y=factor, N=factor))
    found = said(examine(campaign_of(runs)), "units")
    both = [finding for finding in found if finding.message[:2] in ("Y'", "N'")]
    assert len(both) == 2
    assert all(finding.severity == "error" for finding in both)
    assert any(word in finding.message for finding in both)


def test_drift_in_radians_under_a_name_in_degrees():
    runs = [
        run.with_(
            settings=Settings(**{**vars(run.settings), "drift": math.radians(run.settings.drift)})
        )
        for run in programme(speeds=(1.5,))
        if run.test == "static_drift"
    ]
    found = said(examine(campaign_of(runs)), "units")
    assert any("180/π" in finding.message for finding in found)
    assert any("read as radians" in finding.message for finding in found)


def test_speed_in_knots():
    runs = [run_of("R", "resistance", speed=1.5 / 0.514444 * 2)]
    assert any("Froude" in finding.message for finding in examine(campaign_of(runs)))


def lost_means(**factors):
    def change(run: Run, data: xr.Dataset) -> xr.Dataset:
        if not run.dynamic:
            return data
        return data.assign(
            {
                name: data[name] - data[name].mean() * (1 - 1 / factor)
                for name, factor in factors.items()
            }
        )

    return change


@pytest.mark.slow
def test_means_of_oscillating_runs_on_another_scale():
    runs = programme(speeds=(1.5,), change=lost_means(Y=30.0), cycles=5.0, noise=0.0)
    (found,) = said(examine(campaign_of(runs)), "means")
    assert found.severity == "error"
    assert 25 < found.numbers["Y_yaw_drift"] < 32
    assert "one factor" in found.message
    dropped = [run.with_(use_means=False) if run.dynamic else run for run in runs]
    assert said(examine(campaign_of(dropped)), "means") == []


def test_means_without_a_common_factor_are_told_as_such():
    runs = programme(speeds=(1.5,), change=lost_means(Y=30.0, X=100.0), cycles=5.0, noise=0.0)
    found = said(examine(campaign_of(runs)), "means")
    assert {finding.message[:12] for finding in found} == {"The static Y", "The static X"}
    assert all("not one constant" in finding.message for finding in found)


@pytest.mark.slow
def test_moments_about_another_point_break_the_symmetry_of_the_mass_matrix():
    point = 0.05 * SHIP.L

    def shifted(run, data):
        return data.assign(N=data["N"] - point * data["Y"])

    runs = programme(speeds=(1.5,), change=shifted)
    (found,) = said(examine(campaign_of(runs)), "moment reference")
    assert found.numbers["x"] == pytest.approx(point, rel=0.03)
    stated = campaign_of(runs, moment_reference_x=point)
    assert said(examine(stated), "moment reference") == []


@pytest.mark.slow
@pytest.mark.parametrize("sheet", ["C0101A01", "C0101A03"])
def test_moments_about_midship_are_not_doubted_near_the_bottom(sheet, shared_data, tmp_path):
    """Flanders Hydraulics took them about midship; the mass matrix says 0.05 to 0.11 L forward."""
    book = shared_data / "kcs_fhr_shallow" / "App01_KCS_PMM_results_May2014.xlsx"
    if not book.is_file():
        pytest.skip("the measurements of the KCS in shallow water are not here")
    shutil.copy(book, tmp_path)
    draft = campaign_draft(tmp_path, tmp_path / "campaign.toml", sheet=sheet)
    (tmp_path / "campaign.toml").write_text(written(draft).text, encoding="utf-8")
    tank = open_campaign(tmp_path)
    assert said(examine(tank), "moment reference") == []
    aft = tank.with_(moment_reference_x=-0.1 * tank.ship.L)
    assert any("x_over_L" in item.numbers for item in said(examine(aft), "moment reference"))


def test_left_and_right_differ():
    def crooked(run, data):
        return data.assign(Y=data["Y"] + 3.0)

    drift = [run for run in programme(speeds=(1.5,), noise=0.0) if run.test == "static_drift"]
    assert said(examine(campaign_of(drift)), "sides") == []
    runs = programme(speeds=(1.5,), noise=0.0, change=crooked)
    (found,) = said(examine(campaign_of(runs)), "sides")
    assert found.severity == "info"
    largest = max(abs(float(run.data["Y"].mean())) for run in runs if run.test == "static_drift")
    assert found.numbers["Y"] == pytest.approx(3.0 / largest, rel=1e-6)


def test_repeats_that_differ_stand_in_one_sentence():
    """Three settings, each run four times: at two of them Y is off once, by 4 N and 8 N."""
    drifts = [math.radians(angle) for angle in (-8.0, 4.0, 8.0)]

    def off(newtons):
        return lambda run, data: data.assign(Y=data["Y"] + newtons)

    runs = [
        run_of(f"D{k}{n}", "static_drift", noise=0.0, drift=drift, change=off(k * (n == 3) * 4.0))
        for k, drift in enumerate(drifts)
        for n in range(4)
    ]
    found = [x for x in said(examine(campaign_of(runs)), "sides") if "same settings" in x.message]
    (item,) = found
    assert "Y in 2 of 3 by up to" in item.message
    assert "4 runs like D20" in item.message
    assert set(item.runs) == {f"D{k}{n}" for k in (1, 2) for n in range(4)}
    largest = max(abs(float(run.data["Y"].mean())) for run in runs)
    assert item.numbers["Y"] == pytest.approx(8.0 / largest, rel=1e-6)


def test_all_errors_stand_in_one_refusal_and_warnings_do_not_raise():
    runs = programme(speeds=(1.5,), inside=True, change=scaled(X=-1.0))
    findings = examine(campaign_of(runs))
    errors = [finding for finding in findings if finding.severity == "error"]
    with pytest.raises(ContradictionError) as raised:
        refuse(findings)
    assert len(raised.value.problems) == len(errors) > 4
    for finding in errors:
        assert finding.message in str(raised.value)
    refuse(finding for finding in findings if finding.severity != "error")


@pytest.mark.slow
def test_summaries_made_before_give_the_same_findings_without_reading():
    runs = programme(speeds=(1.5,), inside=True)
    whole = campaign_of(runs)
    summaries = [summarise(run, whole) for run in whole.runs]

    def never() -> xr.Dataset:
        raise AssertionError("read again")

    blind = whole.with_(runs=tuple(run.with_(loader=never) for run in whole.runs))
    assert examine(blind, summaries) == examine(whole)


def test_every_finding_names_a_check_of_the_list():
    names = {check.name for check in CHECKS.values()}
    runs = programme(speeds=(1.5,), inside=True, change=scaled(Y=-9.8))
    assert {finding.check for finding in examine(campaign_of(runs))} <= names
    assert len(names) == len(CHECKS)
    assert all(check.description for check in CHECKS.values())
