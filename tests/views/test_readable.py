"""Figures can be read: by eyes of every kind, on paper, by screen readers; texts do not collide."""

from __future__ import annotations

import itertools
from types import SimpleNamespace

import matplotlib as mpl
import numpy as np
import pytest
from scenes import boxes_at, collisions, overlap
from small_campaign import RHO, TRUTH, L

import pmmkit as pk
from pmmkit import converted
from pmmkit.base import DataError, TableError
from pmmkit.campaigns.figures import record
from pmmkit.conventions import Ship, Water
from pmmkit.diagnosis.fall_figures import LEVEL, Bars, Panel, fall
from pmmkit.diagnosis.figures import coverage, evidence
from pmmkit.plotting import Figure, style, trajectory
from pmmkit.plotting.layout import laid_out
from pmmkit.plotting.marks import BarSeries, Rule
from pmmkit.plotting.time_series import histories, zigzag
from pmmkit.plotting.turns import turn_histories
from pmmkit.presentation import Section
from pmmkit.reduction.figures import left_by_the_fit
from pmmkit.simulation import Bands
from pmmkit.simulation.figures import importance
from pmmkit.views import window_figure
from pmmkit.views.figures.derivatives import correlated, correlations
from pmmkit.views.figures.forces import Cycle, over_a_cycle
from pmmkit.views.figures.forests import farthest, forest
from pmmkit.views.figures.workshop import summed_up
from pmmkit.views.pages.sections import told_page
from pmmkit.views.report.pictures import of_derivatives

SHIP = Ship(name="m", L=L, B=0.705556, d=0.236111, volume=0.454861, mass=454.476, Izz=618.332)
WATER = Water(rho=RHO, g=9.81)
VISION = {
    "all cones": np.eye(3),
    "protanopia": np.array(
        [
            [0.152286, 1.052583, -0.204868],
            [0.114503, 0.786281, 0.099216],
            [-0.003882, -0.048116, 1.051998],
        ]
    ),
    "deuteranopia": np.array(
        [
            [0.367322, 0.860646, -0.227968],
            [0.280085, 0.672501, 0.047413],
            [-0.011820, 0.042940, 0.968881],
        ]
    ),
    "tritanopia": np.array(
        [
            [1.255528, -0.076749, -0.178779],
            [-0.078411, 0.930809, 0.147602],
            [0.004733, 0.691367, 0.303900],
        ]
    ),
}
"""Linear RGB as it is seen, severity 1: Machado, Oliveira and Fernandes (2009), table 1."""


def lab(colour, seen_by):
    """CIE 1976 L*a*b* of a colour under D65."""
    rgb = np.array(mpl.colors.to_rgb(colour))
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    to_xyz = np.array(
        [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    )
    xyz = to_xyz @ np.clip(VISION[seen_by] @ linear, 0, 1) / [0.9505, 1.0, 1.089]
    f = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16 / 116)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


@pytest.mark.parametrize("eyes", VISION)
def test_colours_are_told_apart_by_every_kind_of_eyes(eyes):
    places = [lab(colour, eyes) for colour in style.ORDERED]
    distances = [np.linalg.norm(a - b) for a, b in itertools.combinations(places, 2)]
    assert min(distances) > 18.0  # some eight times what is just noticed side by side


def test_colours_are_told_apart_on_paper_without_colour():
    shades = sorted(lab(colour, "all cones")[0] for colour in style.ORDERED)
    assert min(np.diff(shades)) > 11.0


def test_sets_beyond_the_colours_differ_by_their_marks():
    looks = {(style.colour(i), style.marker(i)) for i in range(30)}
    assert len(looks) == 30


@pytest.mark.slow
@pytest.mark.parametrize("length", [4, 25, 60])
def test_a_legend_below_is_as_wide_as_the_figure_at_most(length):
    """Runs have long names; what is short still stands side by side."""
    figure = Figure(height=4.0)
    axis = figure.subplots()
    names = [f"{number}" + "m" * (length - 1) for number in range(4)]
    for number, name in enumerate(names):
        axis.plot([0, 1], [number, number], color="#222222", label=name)
    figure.legend_below([axis], columns=4)
    scene = laid_out(figure)
    assert 0.0 <= scene.legend.left < scene.legend.right <= scene.width
    boxes = [own.box for own in scene.letters if own.text in names]
    assert all(0.0 <= box.left < box.right <= scene.width for box in boxes)
    assert len(boxes) == 4
    assert len({box.left for box in boxes}) == {4: 4, 25: 2, 60: 1}[length]


def test_what_the_phase_is_stands_clear_of_the_legend():
    theta = np.linspace(0.0, 2 * np.pi, 50)
    cycle = Cycle(
        title="pure sway, Fn 0.2",
        theta=theta,
        samples={"Y": np.sin(theta)},
        coefficients={"Y": np.array([0.0, 0.0, 1.0])},
    )
    assert collisions(over_a_cycle([cycle], channels=["Y"])) == []


def lines(ticks):
    """Lines of what is stated at ticks."""
    return {line for label in ticks.labels for line in label.split("\n")}


def test_sets_of_several_effects_have_room_for_their_names():
    sets = [
        ("cubic_hull_terms", "modulus_sway_drag", "yaw_sway_coupling"),
        ("modulus_sway_drag", "modulus_yaw_drag", "yaw_sway_coupling"),
        ("crossflow_drag",),
        ("fault_pmm_amplitude",),
    ]
    figure = evidence(sets, [600.0, 590.0, 400.0, 40.0], named=[True] * 4, faults=[False] * 4)
    (axis,) = figure.axes
    scene = laid_out(figure)
    (frame,) = scene.frames
    boxes = boxes_at(scene, frame, {(text, axis.yticks.size) for text in lines(axis.yticks)})
    assert len(boxes) >= len(sets)
    assert not any(overlap(a, b) for a, b in itertools.combinations(boxes, 2))
    assert "100" in frame.xticks.labels
    assert not any("^" in text for text in frame.xticks.labels)


def test_bars_of_the_steps_differ_in_grey():
    bars = tuple(Bars(label=name, errors=(3.0, 2.0, 1.0)) for name in "XY")
    figure = fall(["base", "a", "b"], [Panel(title="by channel", scale="%", bars=bars)])
    hatches = {mark.hatch for mark in figure.axes[0].marks if isinstance(mark, BarSeries)}
    assert len(hatches) == 3


@pytest.mark.parametrize("count", [2, 4])
@pytest.mark.parametrize("level", [0.2, 0.9, 0.97, 1.0, 1.04, 1.1, 1.15, 1.3])
def test_the_level_crosses_no_number_of_a_fall_and_no_number_another(count, level):
    steps = ["base", "fault_misalignment (tank)", "yaw_sway_coupling", "current"][:count]
    errors = (2.00123, 1.00123, 1.00234, 1.00345)[:count]
    panels = [
        Panel(title=name, scale="error [m]", bars=(Bars(label="", errors=errors, level=level),))
        for name in "abcd"
    ]
    figure = fall(steps, panels)
    scene = laid_out(figure)
    for frame in scene.frames:
        axis = frame.axes
        (line,) = (item for item in axis.marks if isinstance(item, Rule))
        assert line.label == LEVEL
        at = frame.upright(np.array([line.at]))[0]
        boxes = boxes_at(scene, frame, {(text.text, text.size) for text in axis.words})
        assert len(boxes) == count
        assert not any(box.top < at < box.bottom for box in boxes)
        names = boxes_at(scene, frame, {(text, axis.xticks.size) for text in lines(axis.xticks)})
        assert len(names) >= count
        for own in (boxes, names):
            assert not any(overlap(a, b) for a, b in itertools.combinations(own, 2))


def test_without_a_step_there_is_no_fall_to_draw():
    with pytest.raises(DataError, match="no step"):
        fall((), ())


def test_what_hides_beyond_the_axis_is_marked():
    axis = coverage(["a", "b"], [0.1, 1e6], [True, False]).axes[0]
    marks = [line for line in axis.points if line.marker == ">"]
    assert [line.y[0] for line in marks] == [1]


@pytest.mark.slow
@pytest.mark.parametrize("value", [-7.83809, 0.0, 1.17e-9, 2.5e7])
def test_a_channel_that_hardly_changes_has_short_ticks(value):
    t = np.linspace(0.0, 1.0, 50)
    values = value * (1 + 1e-9 * np.sin(40 * t))
    figure = record("run", t, {"X": values}, {"X": "N"})
    (frame,) = laid_out(figure).frames
    assert max(map(len, frame.yticks.labels)) < 8
    assert "+" not in frame.yticks.power


@pytest.mark.slow
def test_residuals_stand_over_the_fitted_value_a_panel_a_kind():
    fitted = np.array([1.0, 2.0, 3.0, 4.0])
    left = np.array([0.3, -0.4, np.nan, 0.0])
    figure = left_by_the_fit(
        {"Y": {"pure sway": (fitted + left, fitted), "static drift": (fitted, fitted)}}, {"Y": "N"}
    )
    sway, drift = figure.axes
    np.testing.assert_allclose(sway.points[0].x, fitted)
    np.testing.assert_allclose(sway.points[0].y, left)
    assert sway.title_right.text == "rms 0.29 N"  # √((0.09 + 0.16 + 0) / 3)
    assert drift.xlabel.text == "Y fitted [N]"
    assert not collisions(figure)


def test_a_stretch_of_a_loop_is_summed_up_by_its_ends_and_mean():
    theta = np.linspace(0.0, 2 * np.pi, 4001)
    middle, low, mean, high = summed_up(np.sin(theta), np.cos(theta))
    inside = np.abs(middle) < 0.7
    np.testing.assert_allclose(mean[inside], 0.0, atol=0.02)
    np.testing.assert_allclose(high[inside], np.sqrt(1 - middle[inside] ** 2), atol=0.06)
    np.testing.assert_allclose(low, -high, atol=1e-9)


@pytest.fixture(scope="module")
def table():
    std = {name: 0.02 * abs(value) for name, value in TRUTH.items()}
    return pk.from_values(TRUTH, ship=SHIP, water=WATER, Fn=[0.2], std=std)


def test_correlations_stand_in_blocks_of_channels(table):
    turned_round = table.select(list(table.names)[::-1])
    names, matrix = correlated(turned_round)
    assert [name[0] for name in names] == sorted((n[0] for n in names), key="XYNK".index)
    i, j = names.index("Yv"), names.index("Yr")
    covariance = turned_round.covariance.copy()
    a, b = turned_round.index("Yv"), turned_round.index("Yr")
    shared = -0.9 * turned_round.std[0, a] * turned_round.std[0, b]
    covariance[0, a, 0, b] = covariance[0, b, 0, a] = shared
    tied = turned_round.with_(covariance=covariance)
    assert correlated(tied)[1][i, j] == pytest.approx(-0.9)
    assert matrix[i, j] == 0.0
    axis = correlations(tied).axes[0]
    assert {text.text for text in axis.words} == {"-90"}
    assert "Y" in axis.yticks.labels[i]


def test_a_table_without_covariance_has_no_correlations():
    bare = pk.from_values(TRUTH, ship=SHIP, water=WATER)
    with pytest.raises(TableError, match="Fewer than two"):
        correlations(bare)


def test_a_forest_of_laboratories_takes_their_own_conventions(table):
    """The same derivatives in the bis system stand on the zero of the first."""
    elsewhere = converted(table, table.convention.with_(system="bis"))
    figure = forest({"HMRI": table, "elsewhere": elsewhere})
    marks = {line.label: line for line in figure.axes[0].points}["elsewhere, 95 %"]
    np.testing.assert_allclose(marks.x, 0.0, atol=1e-6)
    assert len(marks.x) == len(table.names)


@pytest.mark.slow
def test_a_forest_gives_each_derivative_the_rows_that_it_needs(table):
    some = table.select(["Yv", "Nv"])
    figure = forest({"all": table, "drift": some, "sway": table.select(["Yv"])})
    (axis,) = figure.axes
    assert len(axis.yticks.at) == 2
    sway = {line.label: line for line in axis.points}["sway, 95 %"]
    drift = {line.label: line for line in axis.points}["drift, 95 %"]
    places = sorted([*sway.y, *drift.y])
    assert np.min(np.diff(places)) >= 1.0
    assert not collisions(figure)


def test_who_is_farthest_in_a_forest_is_said(table):
    moved = table.select(["Yv", "Nv"])
    moved = moved.with_(value=moved.value * [1.0, 1.1])
    (sentence,) = farthest({"all": table, "drift": moved})
    assert sentence.startswith("1 of 2 values lie outside")
    half = 1.96 * 0.02
    expected = 0.1 / half * np.sign(TRUTH["Nv"])
    assert f"Nv by drift at Fn 0.200, {expected:+.2g} half intervals" in sentence


@pytest.fixture(scope="module")
def bands():
    return Bands.of(
        "kvlcc2-l7", speed=1.179, rudder_deg=35, n=40, spread=0.05, seed=1, compiled=False
    )


@pytest.mark.slow
def test_a_ship_lies_in_the_band_of_those_like_it(bands):
    track = bands.track
    inside = (bands.low["r"] <= track.r + 1e-9) & (track.r <= bands.high["r"] + 1e-9)
    assert inside[np.isfinite(bands.low["r"])].mean() > 0.9
    for name in ("advance_L", "transfer_L", "tactical_diameter_L"):
        low, high = bands.measures[name]
        assert low < track.metrics[name] < high


@pytest.mark.slow
def test_the_band_of_the_path_is_as_wide_as_the_measures_spread(bands):
    """Where the heading has turned by 90° the path runs abeam: the band's height is in advance."""
    k = round((len(bands.inner) - 1) / 4)
    width = np.linalg.norm(bands.outer[k] - bands.inner[k]) / bands.track.L
    low, high = bands.measures["advance_L"]
    assert width == pytest.approx(high - low, rel=0.3)


@pytest.mark.slow
def test_wider_spread_gives_a_wider_band_and_the_same_seed_the_same(bands):
    again = Bands.of(
        "kvlcc2-l7", speed=1.179, rudder_deg=35, n=40, spread=0.05, seed=1, compiled=False
    )
    np.testing.assert_array_equal(again.inner, bands.inner)
    narrow = Bands.of(
        "kvlcc2-l7", speed=1.179, rudder_deg=35, n=40, spread=0.01, seed=1, compiled=False
    )
    size = [np.linalg.norm(item.outer - item.inner, axis=1).mean() for item in (narrow, bands)]
    assert size[1] > 3 * size[0]


@pytest.mark.slow
def test_a_turn_with_its_band_tells_its_measures_and_intervals(bands):
    found = bands.figures()
    assert list(found) == ["trajectory", "histories"]
    texts = [text.text for text in found["trajectory"].axes[0].words]
    for name in ("advance", "transfer", "tactical diameter"):
        (told,) = [text for text in texts if text.startswith(name)]
        low, high = bands.measures[f"{name.replace(' ', '_')}_L"]
        assert f"({low:.2f} to {high:.2f})" in told
    for figure in found.values():
        assert not collisions(figure)
    titles = [axis.title.text for axis in found["histories"].axes]
    assert titles[:2] == ["heading ψ [deg]", "rudder δ [deg]"]
    rudder = found["histories"].axes[1].points[0].y
    assert np.nanmax(rudder) == pytest.approx(35.0)


@pytest.mark.slow
def test_bands_are_the_same_to_the_byte(bands):
    made = [[figure.svg() for figure in bands.figures().values()] for _ in range(2)]
    assert made[0] == made[1]


@pytest.mark.slow
@pytest.mark.parametrize("rudder_deg", [35, -35])
def test_dimension_lines_keep_clear_of_the_path(rudder_deg):
    track = pk.simulate("kvlcc2-l7", speed=1.179, rudder_deg=rudder_deg, compiled=False)
    figure = trajectory([track])
    assert not collisions(figure)
    scene = laid_out(figure)
    (frame,) = scene.frames
    x, y = frame.across(track.y / track.L), frame.upright(track.x / track.L)
    boxes = boxes_at(scene, frame, {(text.text, text.size) for text in frame.axes.words})
    assert boxes
    for box in boxes:
        assert not np.any((box.left < x) & (x < box.right) & (box.top < y) & (y < box.bottom))


@pytest.mark.slow
def test_a_spiral_shows_its_rudder_on_a_scale_of_its_own():
    track = pk.simulate("kvlcc2-l7", "spiral", speed=1.179, step_deg=10, compiled=False)
    axes = {axis.title.text: axis for axis in histories(track).axes}
    rudder = axes["rudder δ [deg]"]
    np.testing.assert_allclose(rudder.points[0].y, np.degrees(track.delta))
    assert max(map(abs, rudder.limits("y"))) < 45


def test_a_zigzag_says_when_the_rudder_was_ordered():
    track = pk.simulate("kvlcc2-l7", "zigzag", speed=1.179, compiled=False)
    above = zigzag([track]).axes[0]
    upright = [x for x in above.marks if isinstance(x, Rule) and "ordered" in x.label]
    assert [line.at for line in upright] == list(track.orders)


@pytest.mark.slow
def test_what_is_seen_is_what_was_drawn(table):
    told = correlations(table).in_words()
    assert f"a map of {len(table.names)} rows" in told
    track = pk.simulate("kvlcc2-l7", speed=1.179, compiled=False)
    told = turn_histories([track]).in_words()
    assert told.startswith("6 panels. Speed over approach speed U / U₀ [-] over time t U₀ / L [-]")
    assert f"{np.degrees(track.delta).min():.3g} to 35" in told.split("Rudder")[1]
    told = forest({"all": table, "half": table.with_(value=1.01 * table.value)}).in_words()
    assert f"{len(table.names)} rows, X′_u-dot to" in told
    assert "half, 95 % −0.255 to 0.255" in told


def test_alternative_texts_of_the_report_say_numbers_beyond_the_caption(table):
    few = table.select(["Yv", "Yr", "Nv"])
    (matrix,) = of_derivatives(few, None)
    assert matrix.alt.startswith("Strongest correlations: Yv and Yr +0.00, ")
    (section,) = told_page(after=[Section(title="Derivatives", figures=[matrix])])["after"]
    assert section["figures"][0]["alt"] == matrix.alt
    assert section["figures"][0]["caption"] == matrix.caption


def test_a_prediction_that_runs_away_leaves_the_axes_not_the_measurement():
    t = np.linspace(0.0, 60.0, 61)
    measured = {"x": 3.0 * t, "y": 0.5 * t, "psi": 0.02 * t}
    away = {"x": 1e24 * t, "y": 1e24 * t, "psi": 1e20 * t}
    window = SimpleNamespace(
        t=t,
        L=10.0,
        name="turn",
        delta=0.1 + 0 * t,
        measured=measured,
        predicted={"before": measured, "ekf": away},
    )
    left, right = window_figure(window).axes
    assert max(map(abs, (*left.limits("x"), *left.limits("y")))) < 100.0
    assert max(map(abs, right.limits("y"))) < 500.0
    assert right.title.text == "runs away: ekf"


def test_rounding_of_zero_is_no_scale():
    """Headings of a ship that stops on a straight course: 1e-19 degrees."""
    axis = Figure(height=2.0).subplots()
    axis.plot([0.0, 1.0], [0.0, 3e-19], color="#222222")
    style.widened(axis)
    assert axis.limits("y") == (-0.055, 0.055)
    axis = Figure(height=2.0).subplots()
    axis.plot([0.0, 1.0], [0.0, 3e-6], color="#222222")
    before = axis.limits("y")
    style.widened(axis)
    assert axis.limits("y") == before


def test_what_the_bars_of_causes_show_stands_within_the_figure():
    names = ["four_quadrant_propeller.t_astern", "Yv"]
    figure = importance(names, np.array([0.7, 0.3]), "steady_speed_ratio", shares=False)
    scene = laid_out(figure)
    (told,) = [own for own in scene.letters if "change of" in own.text]
    assert told.text == figure.xlabel.text
    assert told.box.left >= 0.0
    assert told.box.right <= scene.width


@pytest.mark.slow
def test_bars_of_few_ships_hold_several_and_say_how_many():
    """Sixty bars for sixty ships were a comb; the numbers of ships had no scale."""
    found = pk.monte_carlo("kvlcc2-l7", speed=1.179, rudder_deg=35, n=60, spread=0.05, seed=1)
    figure = found.plot()
    assert not collisions(figure)
    frames = laid_out(figure).frames
    assert frames[0].axes.yticks.shown
    assert len(frames[0].yticks.labels) > 1
    for frame in frames:
        (bars,) = (mark for mark in frame.axes.marks if isinstance(mark, BarSeries))
        assert bars.length.sum() >= 60
        assert np.median(bars.length[bars.length >= 1.0]) > 2
        assert len(frame.xticks.labels) > 1
