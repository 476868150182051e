"""Figures: they show the numbers they are given, with units, and leave nothing behind."""

from __future__ import annotations

import math
import subprocess
import sys
from dataclasses import replace

import matplotlib as mpl
import numpy as np
import pytest
from small_campaign import RHO, TRUTH, L, forces, write_campaign

import pmmkit
from pmmkit.base import DataError, TableError
from pmmkit.conventions import Ship, Water
from pmmkit.plotting import save, style, svg, trajectory
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


def drawn(figure):
    """The axes that are shown."""
    return [axis for axis in figure.axes if axis.axison]


def static(speed, degrees):
    beta = np.radians(degrees)
    still = np.zeros_like(beta)
    u, v = speed * np.cos(beta), -speed * np.sin(beta)
    return forces(u, v, still, still, still, still)


def points_at(froude, degrees):
    force = static(SHIP.speed(froude), np.asarray(degrees, float))
    std = {name: np.full(len(degrees), 2.0) for name in force}
    return DriftPoints(froude=froude, drift=np.radians(degrees), force=force, std=std)


def test_points_over_drift_are_the_forces_made_non_dimensional():
    degrees = [-10.0, 0.0, 5.0, 10.0]
    table = pmmkit.from_values(TRUTH, ship=SHIP, water=WATER, Fn=[0.2])
    figure = forces_over_drift([points_at(0.2, degrees)], table)
    for axis, channel in zip(figure.axes, "XYN", strict=True):
        shown = axis.containers[0][0].get_ydata()
        speed = SHIP.speed(0.2)
        unit = 0.5 * RHO * L**2 * speed**2 * (L if channel == "N" else 1.0)
        expected = 1e3 * static(speed, np.array(degrees))[channel] / unit
        np.testing.assert_allclose(shown, expected, rtol=1e-12)
        np.testing.assert_allclose(axis.containers[0][0].get_xdata(), degrees, rtol=1e-12)


def test_the_curve_of_the_true_derivatives_passes_through_noise_free_points():
    degrees = np.linspace(-12, 16, 15)
    table = pmmkit.from_values(TRUTH, ship=SHIP, water=WATER, Fn=[0.2])
    figure = forces_over_drift([points_at(0.2, degrees)], table)
    for axis in figure.axes:
        curve = next(line for line in axis.lines if len(line.get_xdata()) > 50)
        x, y = axis.containers[0][0].get_data()
        between = np.interp(x, *curve.get_data())
        np.testing.assert_allclose(between, y, atol=2e-3 * np.ptp(y))


def test_the_band_is_the_uncertainty_of_the_force():
    known = {"Yv": TRUTH["Yv"]}
    table = pmmkit.from_values(known, std={"Yv": 1e-4}, ship=SHIP, water=WATER, Fn=[0.2])
    figure = forces_over_drift([points_at(0.2, [0.0, 10.0])], table, channels=["Y"])
    band = figure.axes[0].collections[0].get_paths()[0].vertices
    widest = max(np.ptp(band[np.isclose(band[:, 0], x)][:, 1]) for x in np.unique(band[:, 0]))
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
        curve = next(line for line in figure.axes[0].lines if len(line.get_xdata()) > 50)
        heights.append(curve.get_ydata())
    unit = 0.5 * RHO * L**2 * SHIP.speed(0.2) ** 2
    np.testing.assert_allclose(heights[1] - heights[0], 1e3 * 0.8 * 7.0 / unit, rtol=1e-9)


@pytest.mark.slow
def test_derivatives_over_froude_show_values_and_intervals(table):
    figure = derivatives_over_froude(table, reference=TRUTH, reference_name="truth")
    axes = drawn(figure)
    assert len(axes) == len(TRUTH)
    for axis, name in zip(axes, table.names, strict=True):
        line, _, bars = axis.containers[0]
        np.testing.assert_allclose(line.get_xdata(), FN)
        np.testing.assert_allclose(line.get_ydata(), 1e3 * table[name], rtol=1e-12)
        ends = np.array([part[:, 1] for part in bars[0].get_segments()])
        half = 1.959964 * 0.02 * abs(TRUTH[name]) * 1e3
        np.testing.assert_allclose(np.ptp(ends, axis=1), 2 * half, rtol=1e-4)
        reference = next(line for line in axis.lines if line.get_label() == "truth")
        np.testing.assert_allclose(reference.get_ydata(), 1e3 * TRUTH[name])


@pytest.mark.slow
def test_a_derivative_without_values_is_left_out_or_said_to_be_unknown(table):
    value = table.value.copy()
    value[:, table.index("Nvrr")] = np.nan
    partly = table.with_(value=value)
    figure = derivatives_over_froude(partly)
    assert len(drawn(figure)) == len(TRUTH) - 1
    asked = derivatives_over_froude(partly, names=["Nvrr"])
    assert "not determined" in drawn(asked)[0].texts[0].get_text()


def test_a_pooled_table_has_nothing_to_draw_over_froude():
    pooled = pmmkit.from_values(TRUTH, ship=SHIP, water=WATER)
    with pytest.raises(TableError, match="pooled"):
        derivatives_over_froude(pooled)


def test_beside_a_reference_values_stand_as_ratios(table):
    figure = beside_reference(table, TRUTH)
    axis = figure.axes[1]
    names = [name for name in table.names if name[0] == "Y"]
    for row, ratio in enumerate((1.0, 1.1, 1.2)):
        shown = axis.lines[row].get_xdata()
        np.testing.assert_allclose(shown, np.full(len(names), ratio), rtol=1e-12)
    assert len(axis.get_yticks()) == len(names)


def test_what_lies_outside_the_axis_is_marked_with_its_number(table):
    odd = {**TRUTH, "Nvvv": TRUTH["Nvvv"] / 50}
    figure = beside_reference(table, odd)
    texts = [text.get_text() for axis in figure.axes for text in axis.texts]
    assert {"50", "55", "60"} <= set(texts)


def test_nothing_in_common_is_refused(table):
    with pytest.raises(TableError, match="in common"):
        beside_reference(table, {"Kp": 1.0})


def test_trajectory_in_ship_lengths_marks_advance_and_diameter(track):
    figure = trajectory([track])
    axis = figure.axes[0]
    path = axis.lines[0]
    np.testing.assert_allclose(path.get_xdata(), track.y / track.L)
    np.testing.assert_allclose(path.get_ydata(), track.x / track.L)
    quarter, half = axis.lines[1], axis.lines[2]
    assert quarter.get_ydata()[0] == pytest.approx(track.metrics["advance_L"], abs=0.02)
    assert quarter.get_xdata()[0] == pytest.approx(track.metrics["transfer_L"], abs=0.05)
    assert half.get_xdata()[0] == pytest.approx(track.metrics["tactical_diameter_L"], abs=0.02)
    assert axis.get_aspect() == 1.0
    words = " ".join(text.get_text() for text in axis.texts)
    assert f"tactical diameter {track.metrics['tactical_diameter_L']:.2f} L" in words


@pytest.mark.parametrize("dt", [None, 20.0])
def test_a_figure_tells_the_measures_of_its_track(dt):
    """However far its samples lie apart: transfer is 1.27 L, and 1.42 L at the sample after."""
    turn = pmmkit.simulate("kvlcc2", speed=7.97, dt=dt, compiled=False)
    axis = trajectory([turn]).axes[0]
    words = {text.get_text() for text in axis.texts}
    for name in ("advance", "transfer", "tactical diameter"):
        assert f"{name} {turn.metrics[name.replace(' ', '_') + '_L']:.2f} L" in words
    quarter, half = axis.lines[1], axis.lines[2]
    most = 0.002 if dt is None else 0.05
    for line, names in ((quarter, ("transfer_L", "advance_L")), (half, ("tactical_diameter_L",))):
        for at, name in zip((line.get_xdata()[0], line.get_ydata()[0]), names, strict=False):
            assert at == pytest.approx(turn.metrics[name], abs=most)


def test_outlines_of_the_ship_are_one_length_long(track):
    figure = trajectory([track])
    for patch in figure.axes[0].patches:
        corners = patch.get_xy()
        spread = np.linalg.norm(corners[:, None] - corners[None], axis=2).max()
        assert spread == pytest.approx(1.0, rel=0.01)


def test_a_turn_to_port_is_the_mirror_image(track):
    port = pmmkit.simulate("s175-3dof", speed=9.0, rudder_deg=-35, compiled=False)
    lines = [trajectory([item]).axes[0].lines for item in (track, port)]
    for starboard, mirrored in zip(lines[0][:3], lines[1][:3], strict=True):
        np.testing.assert_allclose(mirrored.get_xdata(), -starboard.get_xdata(), atol=1e-6)


def test_histories_show_speed_yaw_rate_and_drift(track):
    speed, yaw, drift, heading, rudder, _ = turn_histories([track]).axes
    ratio = speed.lines[0].get_ydata()
    assert ratio[0] == pytest.approx(1.0)
    assert ratio[-1] == pytest.approx(track.metrics["speed_ratio"], rel=1e-3)
    assert drift.lines[0].get_ydata()[-1] == pytest.approx(
        track.metrics["steady_drift_deg"], rel=1e-3
    )
    assert rudder.lines[0].get_ydata()[-1] == pytest.approx(track.rudder_deg, abs=0.1)
    np.testing.assert_allclose(heading.lines[0].get_ydata(), np.degrees(np.unwrap(track.psi)))
    diameter = 2 * ratio[-1] / yaw.lines[0].get_ydata()[-1]
    assert diameter == pytest.approx(track.metrics["steady_diameter_L"], rel=1e-3)


def test_no_track_is_refused():
    with pytest.raises(DataError, match="no track"):
        trajectory([])


def test_measures_over_froude_with_the_imo_limits(sweep):
    figure = measures_over_froude({"ours": sweep})
    advance, transfer, diameter, _ = figure.axes
    np.testing.assert_allclose(diameter.lines[0].get_ydata(), sweep.tactical_diameter_L)
    assert advance.lines[1].get_ydata()[0] == 4.5
    assert diameter.lines[1].get_ydata()[0] == 5.0
    assert len(transfer.lines) == 1


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
    recorded, fitted = axis.lines
    between = np.interp(recorded.get_xdata(), fitted.get_xdata(), fitted.get_ydata())
    rest = recorded.get_ydata() - between
    assert np.std(rest) == pytest.approx(1.0, rel=0.15)  # the noise of Y that was put in
    assert recorded.get_xdata().min() >= 0
    assert recorded.get_xdata().max() <= 360


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
        for axis in drawn(figure):
            words = [axis.get_xlabel(), axis.get_ylabel(), axis.get_title(loc="left")]
            column = [
                other
                for other in drawn(figure)
                if other in axis.get_shared_x_axes().get_siblings(axis)
            ]
            below = [other.get_xlabel() for other in column]
            assert any("[" in text for text in (*words, *below)), words


@pytest.mark.slow
def test_no_legend_covers_data(every_figure):
    for figure in every_figure:
        figure.draw_without_rendering()
        panels = [axis.get_window_extent() for axis in drawn(figure)]
        for legend in figure.legends:
            frame = legend.get_window_extent()
            assert not any(frame.overlaps(panel) for panel in panels)
        assert all(axis.get_legend() is None for axis in figure.axes)


@pytest.mark.slow
def test_drawing_changes_no_setting_of_the_user(table):
    before = dict(mpl.rcParams)
    svg(derivatives_over_froude(table, names=["Yv", "Nv"]))
    assert dict(mpl.rcParams) == before


@pytest.mark.slow
def test_the_same_figure_gives_the_same_bytes(table, tmp_path):
    few = table.select(["Yv", "Yr", "Nv"])
    made = [svg(beside_reference(few, TRUTH)) for _ in range(2)]
    assert made[0] == made[1]
    assert made[0].startswith("<svg")
    for ending in ("png", "svg", "pdf"):
        names = [tmp_path / f"{number}.{ending}" for number in range(2)]
        for name in names:
            save(beside_reference(few, TRUTH), name)
        assert names[0].read_bytes() == names[1].read_bytes()


@pytest.mark.slow
def test_figures_do_without_pyplot():
    code = (
        "import sys, pmmkit as pk\nfrom pmmkit.plotting import svg, trajectory\n"
        "svg(trajectory([pk.simulate('s175-3dof', speed=9.0, compiled=False)]))\n"
        "assert 'matplotlib' in sys.modules and 'matplotlib.pyplot' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.slow
def test_a_run_plots_its_record_with_angles_in_degrees(reduction):
    run = next(run for run in reduction.campaign if run.test == "pure_yaw")
    turned = run.with_(loader=lambda: run.data.assign(psi=0.01 * run.data["N"]))
    axes = {axis.get_title(loc="left"): axis for axis in drawn(turned.plot())}
    assert set(axes) == {"X [N]", "Y [N]", "N [N m]", "psi [deg]"}
    shown = axes["psi [deg]"].lines[0].get_ydata()
    np.testing.assert_allclose(shown, np.degrees(0.01 * run.data["N"].values))
    with pytest.raises(DataError, match="no history to draw"):
        run.with_(kind="means").plot()


@pytest.mark.slow
def test_a_campaign_plots_how_many_runs_there_are_of_each_test(reduction):
    (axis,) = reduction.campaign.plot().axes
    said = {(text.xy[0], text.xy[1]): text.get_text() for text in axis.texts}
    titles = [label.get_text() for label in axis.get_yticklabels()]
    assert titles == ["static drift", "pure sway", "pure yaw", "yaw with drift"]
    assert said[(0.145, 0)] == "6"
    assert sum(map(int, said.values())) == len(reduction.campaign)
    with pytest.raises(DataError, match="no run to draw"):
        replace(reduction.campaign, runs=()).plot()


@pytest.mark.slow
def test_a_reduction_plots_what_its_fit_leaves_which_is_noise(reduction):
    """Static means of 20 s at 10 Hz leave the noise of a mean of 200 samples, not the force."""
    noise = {"X": 0.4, "Y": 1.0, "N": 1.5}
    first_row = drawn(reduction.plot())[: len(noise)]
    for axis, channel in zip(first_row, noise, strict=True):
        static_drift = axis.lines[1]
        assert static_drift.get_label() == "static drift"
        assert len(static_drift.get_xdata()) == 12
        left = np.sqrt(np.mean(static_drift.get_ydata() ** 2))
        assert 0.4 < left / (noise[channel] / math.sqrt(200)) < 2.0


def test_a_track_plots_itself(track):
    figure = track.plot()
    np.testing.assert_allclose(figure.axes[0].lines[0].get_ydata(), track.x / track.L)


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
    axes = drawn(figure)
    assert [axis.get_title(loc="left") for axis in axes] == [f"Fn {x:.3f}" for x in FN]
    lines = {line.get_label(): line for line in axes[0].get_lines()}
    half = 1.96 * 0.02
    marks = lines["filter, 95 %"].get_xdata()
    np.testing.assert_allclose(np.abs(marks), 0.01 / half, rtol=1e-3)
    np.testing.assert_allclose(lines["by hand"].get_xdata(), 0.0, atol=1e-9)
    far = {line.get_label(): line for line in axes[2].get_lines()}["by hand"]
    assert len(far.get_xdata()) == 0
    numbers = [abs(float(text.get_text())) for text in axes[2].texts]
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
