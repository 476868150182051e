"""Checks of records: times, flat tops, cycles, sister runs, copies, motions against positions."""

from __future__ import annotations

import math
import re
import shutil
import tracemalloc

import numpy as np
import pytest
import xarray as xr
from checks_programme import campaign_of, hash_of, programme, run_of

from pmmkit import Run, open_campaign
from pmmkit.base import CampaignError, DataError, Problem
from pmmkit.campaigns import Settings
from pmmkit.cli import main
from pmmkit.intake import examine
from pmmkit.intake.checks.track import rate_facts, velocity_facts
from pmmkit.reduction import reduce_campaign


def said(findings, check: str):
    return [finding for finding in findings if finding.check == check]


def sway(change=None, name="PS", **settings) -> Run:
    settings = {"period": 12.5, "amplitude": 0.3, **settings}
    return run_of(name, "pure_sway", change=change, **settings)


def retimed(make):
    def change(run: Run, data: xr.Dataset) -> xr.Dataset:
        return data.assign_coords(t=make(data["t"].values.copy()))

    return change


def backwards(t):
    t[200:210] = t[200:210][::-1]
    return t


def repeated(t):
    t[300:340] = t[300]
    return t


def one_stamp(t):
    t[-1] = 1e7
    return t


def epoch_behind(t):
    t[400:] += 1.7e9
    return t


def gap(t):
    t[250:] += 3.0
    return t


@pytest.mark.parametrize(
    ("make", "severity", "words"),
    [
        (backwards, "error", "Row 202: The time does not increase at 9 of 650 samples"),
        (repeated, "error", "Row 302: The time does not increase at 39 of 650 samples"),
        (
            one_stamp,
            "error",
            "Row 650: The time jumps by 9999935.2 s, where the usual step is 0.1 s",
        ),
        (epoch_behind, "error", "Row 401: The time jumps by 1.7e+09 s"),
        (lambda t: 1000 * t, "error", "A cycle of 12.5 s has only 0.12 samples, at steps of 100 s"),
        (lambda t: np.where(t == 5, np.nan, t), "error", "Row 51: 1 of 650 samples have no time"),
        (lambda t: np.round(t + 0.8 * np.sin(0.3 * t)), "error", "no even clock agrees with them"),
        (lambda t: np.round(t * 1.0173, 2), "warning", "written to 0.0100 s"),
        (gap, "warning", "the longest 3.10 s"),
        (lambda t: t + 0.02 * np.sin(7.3 * t), "info", "scatter by"),
    ],
)
def test_time_stamps(make, severity, words):
    found = said(examine(campaign_of([sway(retimed(make))])), "time stamps")
    assert found[0].severity == severity
    assert words in found[0].message


def paused(t):
    t[250:] += 4 * 12.5
    return t


def shortest(run: Run, data: xr.Dataset) -> xr.Dataset:
    return data.isel(t=slice(2))


@pytest.mark.parametrize(
    "change", [shortest, *map(retimed, (backwards, repeated, one_stamp, epoch_behind, paused))]
)
def test_what_check_refuses_reduce_refuses_in_the_same_words(change):
    campaign = campaign_of([sway(change), sway(name="PS_2", amplitude=0.2)])
    (found,) = [x for x in examine(campaign) if x.severity == "error"]
    assert found.runs == ("PS",)
    with pytest.raises(DataError) as raised:
        reduce_campaign(campaign)
    message = found.message.partition(": ")[2] or found.message
    assert message.lower() in str(raised.value).lower()


def test_a_wrong_stamp_costs_no_memory():
    campaign = campaign_of([sway(retimed(one_stamp))])
    examine(campaign)  # what is imported on the way is not counted
    tracemalloc.start()
    examine(campaign)
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 20e6  # it took 3.75 GB


def test_even_times_are_silent_also_when_written_with_few_digits():
    assert said(examine(campaign_of([sway(step=0.05)])), "time stamps") == []


@pytest.mark.parametrize("decimals", [0, 1])
def test_rounded_stamps_of_a_record_in_memory_tell_its_even_clock(decimals):
    exact = sway(step=1 / 30).data["t"].values
    run = sway(retimed(lambda t: np.round(t, decimals)), step=1 / 30)
    assert said(examine(campaign_of([run])), "time stamps") == []
    np.testing.assert_allclose(run.data["t"], exact, atol=0.1 * 10.0**-decimals)


def test_a_force_cut_off_at_its_limit():
    def clipped(run, data):
        limit = 0.8 * float(np.abs(data["Y"]).max())
        return data.assign(Y=data["Y"].clip(-limit, limit))

    (found,) = said(examine(campaign_of([sway(clipped)])), "saturation")
    assert found.message.startswith("Y stands flat")
    assert 0.3 < found.numbers["share"] < 0.5


def torn(size, places, channel="Y"):
    """A channel with some samples that are off by so many of its standard deviations of noise."""

    def change(run, data):
        values = data[channel].values.copy()
        noise = np.diff(values, 2).std() / math.sqrt(6)
        values[list(places)] += size * noise
        return data.assign({channel: ("t", values)})

    return change


@pytest.mark.parametrize(
    ("size", "places", "count", "severity"),
    [(25.0, (300,), "1 sample ", "info"), (60.0, (300, 301, 302), "3 samples ", "warning")],
)
def test_samples_that_jump_away_and_come_back(size, places, count, severity):
    """One of 25 standard deviations moves the mean by less than its noise, three of 60 by more."""
    (found,) = said(examine(campaign_of([sway(torn(size, places)), sway(name="B")])), "spikes")
    assert found.message.startswith("Y jumps away and comes back in PS: " + count)
    assert (found.severity, found.runs, found.channels) == (severity, ("PS",), ("Y",))


def test_one_sample_in_a_hundred_that_jumps_hides_no_other_and_is_no_noise():
    noise = []
    for size in (60.0, 600.0):
        run = sway(torn(size, range(20, 600, 100)))
        (found,) = said(examine(campaign_of([run])), "spikes")
        assert (found.severity, found.numbers["spikes"]) == ("warning", 6)
        noise.append(found.numbers["noise"])
    assert noise[1] < 2.0 * noise[0] < found.numbers["shift"]


def test_samples_that_jump_are_told_where_what_counts_holds_none_of_them():
    run = run_of("SD", "static_drift", change=torn(60.0, (50, 150)), step=0.3)
    (found,) = said(examine(campaign_of([run])), "spikes")
    assert found.numbers["spikes"] == 2
    assert found.message.endswith(
        "What counts of the record holds none of them, and may be short for them."
    )


def test_a_steady_run_whose_force_grows_to_its_end():
    def growing(run, data):
        return data.assign(Y=data["Y"] * (1 + data["t"] / 120))

    runs = [
        run_of("A", "static_drift", drift=0.14, change=growing),
        run_of("B", "static_drift", drift=0.14),
    ]
    (found,) = said(examine(campaign_of(runs)), "steady")
    assert found.message.startswith("Nothing steady was found in A: ")
    assert (found.severity, found.runs) == ("warning", ("A",))


@pytest.mark.parametrize("change", [torn(6.0, (300,)), torn(60.0, range(300, 340)), None])
def test_noise_and_steps_are_no_spikes(change):
    assert said(examine(campaign_of([sway(change)])), "spikes") == []


def test_rows_that_an_even_record_lacks():
    def lacking(run, data):
        return data.isel(t=np.delete(np.arange(data.sizes["t"]), [200, 301, 302]))

    (found,) = said(examine(campaign_of([sway(lacking)])), "time stamps")
    assert found.severity == "info"
    assert found.message == (
        "Rows of even records are missing: 3 in PS, which else has one each 0.100 s."
    )


@pytest.mark.parametrize("count", [15, 16, 17])
def test_a_record_shorter_than_a_cycle_is_refused_however_few_its_samples(count):
    (found,) = said(
        examine(campaign_of([sway(lambda _, data: data.isel(t=slice(count)))])), "time stamps"
    )
    assert found.severity == "error"


def test_a_force_written_with_few_digits_is_not_cut_off():
    def coarse(run, data):
        return data.assign(Y=np.round(data["Y"] / 4) * 4)

    assert said(examine(campaign_of([sway(coarse)])), "saturation") == []


def test_one_cycle_that_differs():
    def odd(run, data):
        third = (data["t"] >= 2 * run.settings.period) & (data["t"] < 3 * run.settings.period)
        return data.assign(Y=data["Y"] * xr.where(third, 1.15, 1.0))

    (found,) = said(examine(campaign_of([sway(odd)])), "cycles")
    assert found.severity == "warning"
    assert found.numbers["cycle"] == 3
    assert found.numbers["deviation"] == pytest.approx(0.15 * found.numbers["amplitude"], rel=0.1)


def test_forces_that_grow_from_cycle_to_cycle_are_a_trend():
    def growing(run, data):
        return data.assign(N=data["N"] * (1 + 0.03 * data["t"] / run.settings.period))

    (found,) = said(examine(campaign_of([sway(growing)])), "cycles")
    assert "a trend" in found.message
    assert found.message.startswith("The first harmonic of N")
    assert found.numbers["deviation"] == pytest.approx(0.09 * found.numbers["amplitude"], rel=0.2)


def slow_noise(run: Run, data: xr.Dataset) -> xr.Dataset:
    """Noise with a memory of some seconds, as carriages and waves make it."""
    generator = np.random.default_rng(abs(hash_of(run.id)))
    kernel = np.exp(-np.arange(0, 15, 0.1) / 3.0)
    kernel /= np.linalg.norm(kernel)
    size = {"X": 0.3, "Y": 2.0, "N": 4.0}
    return data.assign(
        {
            name: data[name]
            + level * np.convolve(generator.standard_normal(data.sizes["t"]), kernel, "same")
            for name, level in size.items()
        }
    )


@pytest.mark.slow
def test_slow_noise_is_no_difference_between_cycles():
    runs = programme(speeds=(1.0, 1.5), change=slow_noise)
    assert said(examine(campaign_of(runs)), "cycles") == []


@pytest.mark.slow
def test_the_synthetic_s175_programme_is_silent(datasets):
    if not (datasets / "s175" / "campaign.toml").is_file():
        pytest.skip("the S175 programme has not been made")
    findings = examine(open_campaign(datasets / "s175"))
    assert [str(finding) for finding in findings if finding.severity != "info"] == []


def test_noise_alone_is_no_difference_between_cycles():
    assert said(examine(campaign_of([sway(noise=0.5)])), "cycles") == []


def test_a_run_out_of_line_with_its_sisters():
    def late(run, data):
        return data.assign(Y=("t", np.roll(data["Y"].values, 9))) if "_8" in run.id else data

    runs = programme(speeds=(1.5,), change=late)
    found = said(examine(campaign_of(runs)), "sister runs")
    assert {finding.runs for finding in found} == {("PY_1.5_8",)}
    assert found[0].numbers["ratio"] < 0.5 * found[0].numbers["low"]


def copied(of: Run, name: str, factor: float = 1.0, **settings) -> Run:
    changed = Settings(**{**vars(of.settings), **settings})
    return of.with_(id=name, settings=changed, loader=lambda: of.data * factor)


def test_a_copy_with_other_settings_is_an_error_that_names_them():
    one = run_of("YD_12", "static_drift", drift=math.radians(12))
    other = copied(one, "YD_16", drift=math.radians(16))
    (found,) = said(examine(campaign_of([one, other])), "copies")
    assert found.severity == "error"
    assert found.runs == ("YD_12", "YD_16")
    assert "drift angle (12 ° and 16 °)" in found.message


def test_one_measurement_in_two_tables_is_worth_knowing_and_no_error():
    one = run_of("SD_8", "static_drift", drift=math.radians(8))
    shared = copied(one, "DR_8").with_(test="drift_rudder")
    (found,) = said(examine(campaign_of([one, shared])), "copies")
    assert (found.severity, found.runs) == ("info", ("SD_8", "DR_8"))


def test_a_nearly_identical_record_with_other_settings_is_suspicious():
    one = run_of("A", "static_drift", drift=math.radians(12))
    other = copied(one, "B", 1.00001, drift=math.radians(16))
    (found,) = said(examine(campaign_of([one, other])), "copies")
    assert found.severity == "warning"
    assert found.numbers["distance"] == pytest.approx(1e-5, rel=0.01)


def test_a_repeat_with_its_own_noise_is_no_copy():
    runs = [run_of(name, "static_drift", drift=math.radians(12)) for name in ("A", "B")]
    assert said(examine(campaign_of(runs)), "copies") == []


def test_an_id_given_twice():
    runs = [run_of("A", "static_drift", drift=math.radians(d)) for d in (4, 8)]
    found = said(examine(campaign_of(runs)), "copies")
    assert any("2 runs are called A" in finding.message for finding in found)


def turning(lag: float = 0.0, earth: bool = False, knots: bool = False, rudder: float = 1.0) -> Run:
    """A 20/20-like weave of a 3 m model, exact by numerical integration of its velocities."""
    t = np.arange(0, 120, 0.05)
    psi = 0.6 * np.sin(0.25 * t)
    r = 0.6 * 0.25 * np.cos(0.25 * t)
    u, v = 0.8 - 0.05 * np.sin(0.5 * t) ** 2, -0.4 * r
    ahead, across = u * np.cos(psi) - v * np.sin(psi), u * np.sin(psi) + v * np.cos(psi)
    fine = np.concatenate(([0.0], np.cumsum(0.5 * (ahead[1:] + ahead[:-1]) * 0.05)))
    side = np.concatenate(([0.0], np.cumsum(0.5 * (across[1:] + across[:-1]) * 0.05)))
    shown = (ahead, across) if earth else (u, v)
    if lag:
        shown = tuple(np.interp(t - lag, t, part) for part in (ahead, across))
        shown = (
            shown[0] * np.cos(psi) + shown[1] * np.sin(psi),
            -shown[0] * np.sin(psi) + shown[1] * np.cos(psi),
        )
    unit = 1.944 if knots else 1.0
    rdot = -0.6 * 0.25**2 * np.sin(0.25 * t)
    columns = {
        "x": fine,
        "y": side,
        "psi": psi,
        "r": r,
        "u": shown[0] * unit,
        "v": shown[1] * unit,
        "delta": rudder * (r + 8.0 * rdot),
    }
    data = xr.Dataset({name: ("t", part) for name, part in columns.items()}, coords={"t": t})
    return Run(
        id="ZZ", test="zigzag", kind="history", loader=lambda: data, settings=Settings(speed=0.8)
    )


def towed(*, heave: float, force: float, own: float = 7.0) -> Run:
    """A model towed straight that heaves at 7 rad/s, by metres; X swings by newtons at its own."""
    t = np.arange(0.0, 60.0, 0.025)
    rng = np.random.default_rng(8)
    columns = {
        "X": -7.0 + force * np.sin(own * t) + rng.normal(0.0, 0.6, len(t)),
        "Y": rng.normal(0.0, 0.6, len(t)),
        "N": rng.normal(0.0, 0.6, len(t)),
        "sinkage": 0.004 + heave * np.cos(7.0 * t) + rng.normal(0.0, 2e-4, len(t)),
    }
    data = xr.Dataset({name: ("t", part) for name, part in columns.items()}, coords={"t": t})
    settings = Settings(speed=0.9)
    return Run(id="R1", test="resistance", kind="history", loader=lambda: data, settings=settings)


def test_a_model_towed_through_waves_is_told():
    (found,) = said(examine(campaign_of([towed(heave=0.012, force=9.0)])), "waves")
    assert found.severity == "warning"
    assert found.numbers["swing"] == pytest.approx(9.0, rel=0.05)
    assert found.numbers["period"] == pytest.approx(2 * math.pi / 7.0, rel=0.02)


@pytest.mark.parametrize(
    ("heave", "force", "own"),
    [(0.0, 0.0, 7.0), (0.012, 0.7, 7.0), (0.0, 9.0, 7.0), (0.012, 9.0, 31.0)],
    ids=["calm", "a little", "the carriage shakes", "two causes"],
)
def test_other_swings_are_no_waves(heave, force, own):
    run = towed(heave=heave, force=force, own=own)
    assert not said(examine(campaign_of([run])), "waves")


@pytest.mark.parametrize("name", ["C1", "C2", "C3"])
def test_calm_water_of_the_dtc_is_silent(shared_data, tmp_path, name):
    """Three runs of another laboratory's benchmark, from rest to rest."""
    ship = {"L": 3.984, "B": 0.572, "d": 0.163, "volume": 0.2444, "Izz": 240.0}
    shutil.copy(shared_data / "dtc_captive" / f"{name}.dat", tmp_path)
    assert main(["new-campaign", str(tmp_path)]) == 0
    file = tmp_path / "campaign.toml"
    text = file.read_text("utf-8")
    for key, value in ship.items():
        text = re.sub(
            rf"(?m)^# {'mass' if key == 'volume' else key} = .*", f"{key} = {value}", text
        )
    file.write_text(text, "utf-8")
    assert not said(examine(open_campaign(tmp_path)), "waves")


def free(run: Run):
    return examine(campaign_of([run], kind="free-running"))


def test_velocities_that_are_those_of_the_positions_are_silent():
    findings = free(turning())
    assert [finding for finding in findings if finding.severity != "info"] == []


def test_columns_u_and_v_in_earth_axes():
    (found,) = said(free(turning(earth=True)), "velocities")
    assert found.severity == "error"
    assert "xdot and ydot" in found.remedy
    assert found.numbers["earth"] < 0.01 * found.numbers["body"]


def test_velocities_that_lag_are_told_with_the_lag():
    found = said(free(turning(lag=0.7)), "velocities")
    assert found[0].numbers["lag"] == pytest.approx(0.7, abs=0.02)


def test_velocities_in_knots_are_told_with_the_factor():
    found = said(free(turning(knots=True)), "velocities")
    assert any("knots" in finding.message and finding.severity == "error" for finding in found)


def test_rudder_of_a_free_running_test_to_the_other_side():
    (found,) = said(free(turning(rudder=-1.0)), "signs")
    assert 'rudder_positive = "port"' in found.remedy


def test_positions_that_jump():
    def jumping() -> xr.Dataset:
        data = turning().data
        return data.assign(x=data["x"] + xr.where(data["t"] > 60, 0.5, 0.0))

    found = said(free(turning().with_(loader=jumping)), "velocities")
    assert any(finding.numbers.get("jump", 0) == pytest.approx(0.5, abs=0.01) for finding in found)


def test_lag_and_scale_of_closed_form_motions():
    t = np.arange(0, 100, 0.02)
    facts = rate_facts(t, np.sin(0.5 * t), 1.03 * 0.5 * np.cos(0.5 * (t - 0.4)))
    assert facts["lag"] == pytest.approx(0.4, abs=0.01)
    straight = velocity_facts(t, 2 * t, 0 * t, 0 * t, 0 * t + 2.0, 0 * t)
    assert straight["body"] < 1e-9
    assert straight["scale"] == pytest.approx(1.0)


def test_a_yaw_rate_in_degrees_and_one_of_the_wrong_sign():
    def rate(factor):
        def change(run, data):
            psi = run.settings.yaw_amplitude * np.sin(run.settings.omega * data["t"])
            return data.assign(psi=psi, r=data["r"] * factor)

        return run_of("PY", "pure_yaw", period=13.2, yaw_amplitude=0.15, motion=True, change=change)

    assert said(examine(campaign_of([rate(1.0)])), "velocities") == []
    found = said(examine(campaign_of([rate(180 / math.pi)])), "velocities")
    assert any("degrees against radians" in finding.message for finding in found)
    found = said(examine(campaign_of([rate(-1.0)])), "velocities")
    assert any("opposite sign" in finding.message for finding in found)


def test_a_recorded_amplitude_that_is_not_the_one_stated():
    def wide(run, data):
        return data.assign(v=data["v"] * 2.0, vdot=data["vdot"] * 2.0)

    exact = sway(motion=True)
    assert said(examine(campaign_of([exact])), "settings") == []
    (found,) = said(examine(campaign_of([sway(wide, motion=True)])), "settings")
    assert found.severity == "error"
    assert found.numbers["ratio"] == pytest.approx(2.0, rel=1e-6)


def test_a_recorded_drift_that_is_not_the_one_stated():
    run = run_of("SD", "static_drift", drift=math.radians(8), motion=True)
    assert said(examine(campaign_of([run])), "settings") == []
    off = run.with_(settings=Settings(speed=1.5, drift=math.radians(-8)))
    (found,) = said(examine(campaign_of([off])), "settings")
    assert found.numbers["drift_deg"] == pytest.approx(8.0, abs=1e-6)


def test_runs_that_cannot_be_read_are_told_all_at_once():
    def broken(name):
        def load():
            raise CampaignError(Problem(message="is cut off", file=f"{name}.csv", run=name))

        return run_of(name, "static_drift").with_(loader=load)

    with pytest.raises(CampaignError) as raised:
        examine(campaign_of([broken("A"), run_of("C", "static_drift"), broken("B")]))
    assert [problem.run for problem in raised.value.problems] == ["A", "B"]


def test_samples_without_a_number_do_not_stop_the_checks():
    def holes(run, data):
        return data.assign(Y=data["Y"].where((data["t"] < 20) | (data["t"] > 21)))

    assert said(examine(campaign_of([sway(holes)])), "cycles") == []


@pytest.mark.parametrize("late", [0.033, 0.25, 2.97, 5.0, -12.0])
def test_a_lag_is_found_between_the_lags_that_are_tried_and_beyond_the_first(late):
    t = np.arange(0.0, 300.0, 0.1)
    place = np.stack([2.0 * t - np.cos(0.3 * t), np.sin(0.17 * t + 1.0)])
    u, v = 2.0 + 0.3 * np.sin(0.3 * (t - late)), 0.17 * np.cos(0.17 * (t - late) + 1.0)
    facts = velocity_facts(t, *place, 0.0 * t, u, v)
    assert facts["lag"] == pytest.approx(late, abs=1e-3)
    assert facts["lagged"] < 1e-4


def test_what_grows_less_like_the_positions_the_further_it_is_moved_is_not_late():
    t = np.arange(0.0, 100.0, 0.1)
    facts = velocity_facts(t, 0.01 * t**2, 0.0 * t, 0.0 * t, 0.02 * (t - 40.0), 0.0 * t)
    assert (facts["lag"], math.isnan(facts["lagged"])) == (0.0, True)
