"""Figures: they show the numbers they are given, with units, and leave nothing behind."""

from __future__ import annotations

import math
import subprocess
import sys
from dataclasses import replace

import matplotlib as mpl
import numpy as np
import pytest
from scenes import collisions, overlap
from small_campaign import RHO, TRUTH, L, forces, write_campaign

import pmmkit
from pmmkit.base import DataError, TableError
from pmmkit.conventions import Ship, Water
from pmmkit.plotting import style, trajectory
from pmmkit.plotting.layout import laid_out
from pmmkit.plotting.marks import Area, Polygons, Rule
from pmmkit.plotting.turns import turn_histories
from pmmkit.simulation import measures_over_froude
from pmmkit.views import beside_reference
from pmmkit.views.figures.derivatives import derivatives_over_froude
from pmmkit.views.figures.forces import (
    DriftPoints,
    cycles_by_froude,
    forces_over_drift,
    over_a_cycle,
)
from pmmkit.views.figures.forests import forest
from pmmkit.views.report.pictures import cycles_at_speeds, drift_points, typical_cycles

SHIP = Ship(name="m", L=L, B=0.705556, d=0.236111, volume=0.454861, mass=454.476, Izz=618.332)
WATER = Water(rho=RHO, g=9.81)
FN = [0.1448, 0.2172, 0.2896]


@pytest.fixture(scope="module")
def table():
    values = {name: [value, 1.1 * value, 1.2 * value] for name, value in TRUTH.items()}
    std = {name: 0.02 * abs(value) for name, value in TRUTH.items()}
    return pmmkit.from_values(values, ship=SHIP, water=WATER, Fn=FN, std=std)


@pytest.fixture(scope="module")
def track():
    return pmmkit.simulate("s175-3dof", speed=9.0, compiled=False)


@pytest.fixture(scope="module")
def sweep():
    return pmmkit.froude_sweep("s175-3dof", [6.0, 12.0], compiled=False)


@pytest.fixture(scope="module")
def reduction(tmp_path_factory):
    folder = write_campaign(tmp_path_factory.mktemp("figures") / "small")
    return pmmkit.reduce_campaign(pmmkit.open_campaign(folder))


def static(speed, degrees):
    beta = np.radians(degrees)
    still = np.zeros_like(beta)
    u, v = speed * np.cos(beta), -speed * np.sin(beta)
    return forces(u, v, still, still, still, still)


def points_at(froude, degrees):
    force = static(SHIP.speed(froude), np.asarray(degrees, float))
    std = {name: np.full(len(degrees), 2.0) for name in force}
    return DriftPoints(froude=froude, drift=np.radians(degrees), force=force, std=std)


def measured(axis):
    """The points of an axis that have intervals."""
    return next(line for line in axis.points if line.y_error is not None)


def test_points_over_drift_are_the_forces_made_non_dimensional():
    degrees = [-10.0, 0.0, 5.0, 10.0]
    table = pmmkit.from_values(TRUTH, ship=SHIP, water=WATER, Fn=[0.2])
    figure = forces_over_drift([points_at(0.2, degrees)], table)
    for axis, channel in zip(figure.axes, "XYN", strict=True):
        shown = measured(axis)
        speed = SHIP.speed(0.2)
        unit = 0.5 * RHO * L**2 * speed**2 * (L if channel == "N" else 1.0)
        expected = 1e3 * static(speed, np.array(degrees))[channel] / unit
        np.testing.assert_allclose(shown.y, expected, rtol=1e-12)
        np.testing.assert_allclose(shown.x, degrees, rtol=1e-12)


def test_the_curve_of_the_true_derivatives_passes_through_noise_free_points():
    degrees = np.linspace(-12, 16, 15)
    table = pmmkit.from_values(TRUTH, ship=SHIP, water=WATER, Fn=[0.2])
    figure = forces_over_drift([points_at(0.2, degrees)], table)
    for axis in figure.axes:
        curve = next(line for line in axis.points if len(line.x) > 50)
        shown = measured(axis)
        between = np.interp(shown.x, curve.x, curve.y)
        np.testing.assert_allclose(between, shown.y, atol=2e-3 * np.ptp(shown.y))


def test_the_band_is_the_uncertainty_of_the_force():
    known = {"Yv": TRUTH["Yv"]}
    table = pmmkit.from_values(known, std={"Yv": 1e-4}, ship=SHIP, water=WATER, Fn=[0.2])
    figure = forces_over_drift([points_at(0.2, [0.0, 10.0])], table, channels=["Y"])
    (band,) = (mark for mark in figure.axes[0].marks if isinstance(mark, Area))
    widest = np.max(band.high - band.low)
    furthest = math.sin(math.radians(10.3))
    assert widest == pytest.approx(2 * 1.96 * 1e3 * 1e-4 * furthest, rel=1e-3)


def test_thrust_lifts_the_curve_of_the_surge_force():
    values = {"Xuu": TRUTH["Xuu"], "XT": 0.8}
    table = pmmkit.from_values(values, ship=SHIP, water=WATER, Fn=[0.2])
    plain = points_at(0.2, [-5.0, 0.0, 5.0])
    thrust = np.full(3, 7.0)
    heights = []
    for points in (plain, replace(plain, thrust=thrust)):
        figure = forces_over_drift([points], table, channels=["X"])
        curve = next(line for line in figure.axes[0].points if len(line.x) > 50)
        heights.append(curve.y)
    unit = 0.5 * RHO * L**2 * SHIP.speed(0.2) ** 2
    np.testing.assert_allclose(heights[1] - heights[0], 1e3 * 0.8 * 7.0 / unit, rtol=1e-9)


@pytest.mark.slow
def test_derivatives_over_froude_show_values_and_intervals(table):
    figure = derivatives_over_froude(table, reference=TRUTH, reference_name="truth")
    axes = figure.shown
    assert len(axes) == len(TRUTH)
    for axis, name in zip(axes, table.names, strict=True):
        line = measured(axis)
        np.testing.assert_allclose(line.x, FN)
        np.testing.assert_allclose(line.y, 1e3 * table[name], rtol=1e-12)
        half = 1.959964 * 0.02 * abs(TRUTH[name]) * 1e3
        np.testing.assert_allclose(line.y_error, half, rtol=1e-4)
        reference = next(line for line in axis.points if line.label == "truth")
        np.testing.assert_allclose(reference.y, 1e3 * TRUTH[name])


@pytest.mark.slow
def test_a_derivative_without_values_is_left_out_or_said_to_be_unknown(table):
    value = table.value.copy()
    value[:, table.index("Nvrr")] = np.nan
    partly = table.with_(value=value)
    figure = derivatives_over_froude(partly)
    assert len(figure.shown) == len(TRUTH) - 1
    asked = derivatives_over_froude(partly, names=["Nvrr"])
    assert "not determined" in asked.shown[0].words[0].text


def test_a_pooled_table_has_nothing_to_draw_over_froude():
    pooled = pmmkit.from_values(TRUTH, ship=SHIP, water=WATER)
    with pytest.raises(TableError, match="pooled"):
        derivatives_over_froude(pooled)


def test_beside_a_reference_values_stand_as_ratios(table):
    figure = beside_reference(table, TRUTH)
    axis = figure.axes[1]
    names = [name for name in table.names if name[0] == "Y"]
    for row, ratio in enumerate((1.0, 1.1, 1.2)):
        shown = axis.points[row].x
        np.testing.assert_allclose(shown, np.full(len(names), ratio), rtol=1e-12)
    assert len(axis.yticks.at) == len(names)


def test_what_lies_outside_the_axis_is_marked_with_its_number(table):
    odd = {**TRUTH, "Nvvv": TRUTH["Nvvv"] / 50}
    figure = beside_reference(table, odd)
    texts = [text.text for axis in figure.axes for text in axis.words]
    assert {"50", "55", "60"} <= set(texts)
    assert collisions(figure) == []


def test_nothing_in_common_is_refused(table):
    with pytest.raises(TableError, match="in common"):
        beside_reference(table, {"Kp": 1.0})


def test_trajectory_in_ship_lengths_marks_advance_and_diameter(track):
    figure = trajectory([track])
    axis = figure.axes[0]
    path = axis.points[0]
    np.testing.assert_allclose(path.x, track.y / track.L)
    np.testing.assert_allclose(path.y, track.x / track.L)
    quarter, half = axis.points[1], axis.points[2]
    assert quarter.y[0] == pytest.approx(track.metrics["advance_L"], abs=0.02)
    assert quarter.x[0] == pytest.approx(track.metrics["transfer_L"], abs=0.05)
    assert half.x[0] == pytest.approx(track.metrics["tactical_diameter_L"], abs=0.02)
    assert axis.equal
    words = " ".join(text.text for text in axis.words)
    assert f"tactical diameter {track.metrics['tactical_diameter_L']:.2f} L" in words


@pytest.mark.parametrize("dt", [None, 20.0])
def test_a_figure_tells_the_measures_of_its_track(dt):
    """However far its samples lie apart: transfer is 1.27 L, and 1.42 L at the sample after."""
    turn = pmmkit.simulate("kvlcc2", speed=7.97, dt=dt, compiled=False)
    axis = trajectory([turn]).axes[0]
    words = {text.text for text in axis.words}
    for name in ("advance", "transfer", "tactical diameter"):
        assert f"{name} {turn.metrics[name.replace(' ', '_') + '_L']:.2f} L" in words
    quarter, half = axis.points[1], axis.points[2]
    most = 0.002 if dt is None else 0.05
    for line, names in ((quarter, ("transfer_L", "advance_L")), (half, ("tactical_diameter_L",))):
        for at, name in zip((line.x[0], line.y[0]), names, strict=False):
            assert at == pytest.approx(turn.metrics[name], abs=most)


def test_outlines_of_the_ship_are_one_length_long(track):
    figure = trajectory([track])
    ships = [mark for mark in figure.axes[0].marks if isinstance(mark, Polygons)]
    assert ships
    for corners in np.concatenate([ship.corners for ship in ships]):
        spread = np.linalg.norm(corners[:, None] - corners[None], axis=2).max()
        assert spread == pytest.approx(1.0, rel=0.01)


def test_a_turn_to_port_is_the_mirror_image(track):
    port = pmmkit.simulate("s175-3dof", speed=9.0, rudder_deg=-35, compiled=False)
    lines = [trajectory([item]).axes[0].points for item in (track, port)]
    for starboard, mirrored in zip(lines[0][:3], lines[1][:3], strict=True):
        np.testing.assert_allclose(mirrored.x, -starboard.x, atol=1e-6)


def test_histories_show_speed_yaw_rate_and_drift(track):
    speed, yaw, drift, heading, rudder, _ = turn_histories([track]).axes
    ratio = speed.points[0].y
    assert ratio[0] == pytest.approx(1.0)
    assert ratio[-1] == pytest.approx(track.metrics["speed_ratio"], rel=1e-3)
    assert drift.points[0].y[-1] == pytest.approx(track.metrics["steady_drift_deg"], rel=1e-3)
    assert rudder.points[0].y[-1] == pytest.approx(track.rudder_deg, abs=0.1)
    np.testing.assert_allclose(heading.points[0].y, np.degrees(np.unwrap(track.psi)))
    diameter = 2 * ratio[-1] / yaw.points[0].y[-1]
    assert diameter == pytest.approx(track.metrics["steady_diameter_L"], rel=1e-3)


def test_no_track_is_refused():
    with pytest.raises(DataError, match="no track"):
        trajectory([])


def test_measures_over_froude_with_the_imo_limits(sweep):
    figure = measures_over_froude({"ours": sweep})
    advance, transfer, diameter, _ = figure.axes
    np.testing.assert_allclose(diameter.points[0].y, sweep.tactical_diameter_L)
    limits = {axis: [x.at for x in axis.marks if isinstance(x, Rule)] for axis in figure.axes}
    assert (limits[advance], limits[diameter], limits[transfer]) == ([4.5], [5.0], [])
    assert len(transfer.points) == 1


@pytest.mark.slow
def test_static_means_of_a_campaign_come_with_their_settings(reduction):
    sets = drift_points(reduction)
    assert [round(item.froude, 3) for item in sets] == [0.145, 0.29]
    np.testing.assert_allclose(np.degrees(sets[0].drift), [-8, -4, 0, 4, 8, 12])
    truth = static(2.0, np.array([-8.0, -4, 0, 4, 8, 12]))
    for channel, values in truth.items():
        error = (sets[1].force[channel] - values) / sets[1].std[channel]
        assert np.max(np.abs(error)) < 4.5


@pytest.mark.slow
def test_harmonics_follow_the_record_of_a_cycle(reduction):
    cycles = typical_cycles(reduction)
    assert [cycle.title.split(",")[0] for cycle in cycles] == [
        "pure sway",
        "pure yaw",
        "yaw with drift",
    ]
    figure = over_a_cycle(cycles)
    axis = figure.axes[3]
    recorded, fitted = axis.points
    between = np.interp(recorded.x, fitted.x, fitted.y)
    rest = recorded.y - between
    assert np.std(rest) == pytest.approx(1.0, rel=0.15)  # the noise of Y that was put in
    assert recorded.x.min() >= 0
    assert recorded.x.max() <= 360


@pytest.fixture(scope="module")
def every_figure(table, track, reduction, sweep):
    return (
        forces_over_drift(drift_points(reduction), reduction.table),
        over_a_cycle(typical_cycles(reduction)),
        derivatives_over_froude(table),
        beside_reference(table, TRUTH),
        trajectory([track]),
        turn_histories([track]),
        measures_over_froude({"ours": sweep}),
    )


@pytest.mark.slow
def test_every_axis_says_its_unit(every_figure):
    for figure in every_figure:
        for axis in figure.shown:
            words = [axis.xlabel.text, axis.ylabel.text, axis.title.text]
            below = [other.xlabel.text for other in axis.xshared if not other.removed]
            assert any("[" in text for text in (*words, *below)), words


@pytest.mark.slow
def test_no_legend_covers_data(every_figure):
    for figure in every_figure:
        scene = laid_out(figure)
        assert len(scene.frames) == len(figure.shown)
        if scene.legend:
            assert not any(overlap(scene.legend, frame.box) for frame in scene.frames)


@pytest.mark.slow
def test_drawing_changes_no_setting_of_the_user(table):
    before = dict(mpl.rcParams)
    figure = derivatives_over_froude(table, names=["Yv", "Nv"])
    figure.svg()
    figure.png(50)
    assert dict(mpl.rcParams) == before


@pytest.mark.slow
def test_the_same_figure_gives_the_same_bytes(table, tmp_path):
    few = table.select(["Yv", "Yr", "Nv"])
    made = [beside_reference(few, TRUTH).svg() for _ in range(2)]
    assert made[0] == made[1]
    assert made[0].startswith("<svg")
    for ending in ("png", "svg", "pdf"):
        names = [tmp_path / f"{number}.{ending}" for number in range(2)]
        for name in names:
            beside_reference(few, TRUTH).save(name)
        assert names[0].read_bytes() == names[1].read_bytes()


@pytest.mark.slow
def test_figures_do_without_matplotlib_and_pictures_without_pyplot():
    code = (
        "import sys, pmmkit as pk\nfrom pmmkit.plotting import trajectory\n"
        "figure = trajectory([pk.simulate('s175-3dof', speed=9.0, compiled=False)])\n"
        "assert figure.svg() and 'matplotlib' not in sys.modules\n"
        "assert figure.png(50) and 'matplotlib.pyplot' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.slow
def test_a_run_plots_its_record_with_angles_in_degrees(reduction):
    run = next(run for run in reduction.campaign if run.test == "pure_yaw")
    turned = run.with_(loader=lambda: run.data.assign(psi=0.01 * run.data["N"]))
    axes = {axis.title.text: axis for axis in turned.plot().shown}
    assert set(axes) == {"X [N]", "Y [N]", "N [N m]", "psi [deg]"}
    shown = axes["psi [deg]"].points[0].y
    np.testing.assert_allclose(shown, np.degrees(0.01 * run.data["N"].values))
    with pytest.raises(DataError, match="no history to draw"):
        run.with_(kind="means").plot()


@pytest.mark.slow
def test_a_campaign_plots_how_many_runs_there_are_of_each_test(reduction):
    (axis,) = reduction.campaign.plot().axes
    said = {(text.x, text.y): text.text for text in axis.words}
    assert axis.yticks.labels == ("static drift", "pure sway", "pure yaw", "yaw with drift")
    assert said[(0.145, 0)] == "6"
    assert sum(map(int, said.values())) == len(reduction.campaign)
    with pytest.raises(DataError, match="no run to draw"):
        replace(reduction.campaign, runs=()).plot()


@pytest.mark.slow
def test_a_reduction_plots_what_its_fit_leaves_which_is_noise(reduction):
    """Static means of 20 s at 10 Hz leave the noise of a mean of 200 samples, not the force."""
    noise = {"X": 0.4, "Y": 1.0, "N": 1.5}
    first_row = reduction.plot().shown[: len(noise)]
    for axis, channel in zip(first_row, noise, strict=True):
        static_drift = axis.points[0]
        assert static_drift.label == "static drift"
        assert len(static_drift.x) == 12
        left = np.sqrt(np.mean(static_drift.y**2))
        assert 0.4 < left / (noise[channel] / math.sqrt(200)) < 2.0


def test_a_track_plots_itself(track):
    figure = track.plot()
    np.testing.assert_allclose(figure.axes[0].points[0].y, track.x / track.L)


def test_colours_of_ordered_sets_differ_in_lightness():
    def lightness(colour):
        red, green, blue = mpl.colors.to_rgb(colour)
        return 0.2126 * red**2.2 + 0.7152 * green**2.2 + 0.0722 * blue**2.2

    shades = [lightness(colour) for colour in style.ORDERED[:3]]
    assert shades == sorted(shades)
    assert min(np.diff(shades)) > 0.08


def test_a_forest_shows_every_method_beside_published_values(table):
    """Values 1 % off stand half an interval of 2 % beside the first; published ones as crosses."""
    other = table.with_(value=1.01 * table.value)
    figure = forest(
        {"regression": table, "filter": other}, reference=TRUTH, reference_name="by hand"
    )
    axes = figure.shown
    assert [axis.title.text for axis in axes] == [f"Fn {x:.3f}" for x in FN]
    lines = {line.label: line for line in axes[0].points}
    half = 1.96 * 0.02
    marks = lines["filter, 95 %"].x
    np.testing.assert_allclose(np.abs(marks), 0.01 / half, rtol=1e-3)
    np.testing.assert_allclose(lines["by hand"].x, 0.0, atol=1e-9)
    far = {line.label: line for line in axes[2].points}["by hand"]
    assert len(far.x) == 0
    numbers = [abs(float(text.text)) for text in axes[2].words]
    np.testing.assert_allclose(numbers, 0.2 / half, atol=0.01)


def test_a_forest_of_one_method_is_refused(table):
    with pytest.raises(TableError, match="at least two"):
        forest({"regression": table})


@pytest.mark.slow
def test_cycles_of_one_motion_at_several_speeds_are_those_of_the_tests(reduction):
    """Of tests made by one set of derivatives the curves of all speeds are the same."""
    found = cycles_at_speeds(reduction)
    for runs in found.values():
        speeds = [froude for froude, _, _ in runs]
        assert speeds == sorted(set(speeds))
        assert len(speeds) > 1
        (_, first, noise), *others = runs
        for _, other, covariance in others:
            for channel, c in other.items():
                both = [np.diagonal(x[channel]) for x in (noise, covariance)]
                away = (c - first[channel]) / np.sqrt(both[0] + both[1])
                assert np.max(np.abs(away)) < 4.5
    assert len(cycles_by_froude(found).axes) == 3 * len(found)
