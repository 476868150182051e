"""Figures laid out: ticks, limits and letters as others have them; nothing covers anything else."""

from __future__ import annotations

import itertools
import math
import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pmmkit.base import DataError
from pmmkit.plotting import RED_BLUE, Figure, Shades
from pmmkit.plotting.axes import Title
from pmmkit.plotting.extent import Ticks, ticks
from pmmkit.plotting.layout import fitted, laid_out
from pmmkit.plotting.letters import width_of
from pmmkit.plotting.scene import Fill
from pmmkit.plotting.vector import thinned

INK = "#222222"
SPACE = "{http://www.w3.org/2000/svg}"


def numbers(found):
    """What is written at ticks, as a reader takes it."""
    digits = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
    power = 10.0 ** int(found.power.removeprefix("×10").translate(digits)) if found.power else 1.0
    return [float(text.replace("−", "-")) * power for text in found.labels]


@given(
    st.floats(-1e9, 1e9).map(lambda x: float(f"{x:.6g}")),
    st.floats(1e-6, 1e9).map(lambda x: float(f"{x:.6g}")),
    st.integers(1, 9),
)
@settings(max_examples=300, deadline=None)
def test_ticks_are_round_inside_and_say_where_they_stand(low, span, room):
    span = max(span, 1e-3 * abs(low))
    found = ticks((low, low + span), room, Ticks(), "linear", 1.0)
    at = np.array(found.at)
    assert 2 <= len(at) <= max(room + 1, 4)
    assert np.all((at >= low - 1e-6 * span) & (at <= low + span + 1e-6 * span))
    if len(at) > 1:
        step = np.diff(at).mean()
        mantissa = step / 10.0 ** math.floor(math.log10(step) + 1e-9)
        assert min(abs(mantissa - own) for own in (1.0, 2.0, 2.5, 5.0, 10.0)) < 1e-6
        np.testing.assert_allclose(numbers(found), at, atol=1e-6 * step + 1e-9 * abs(low))


def test_ticks_are_those_of_matplotlib():
    from matplotlib.ticker import MaxNLocator

    for low, high in ((0.0, 1.05), (-0.3, 7.9), (13.0, 14.2), (-1e-4, 3e-4), (0.0, 83.0)):
        for room in (3, 5, 9):
            theirs = MaxNLocator(nbins=room, steps=[1, 2, 2.5, 5, 10]).tick_values(low, high)
            inside = theirs[(theirs >= low - 1e-12) & (theirs <= high + 1e-12)]
            ours = ticks((low, high), room, Ticks(), "linear", 1.0)
            np.testing.assert_allclose(ours.at, inside, atol=1e-12)


@pytest.mark.parametrize(
    "draw",
    [
        lambda axis: axis.plot([3.0, 7.0, 9.0], [-2.0, 4.0, 1.0], color=INK),
        lambda axis: axis.bar([1.0, 2.0, 3.0], [4.0, 9.0, 2.0], color=INK),
        lambda axis: axis.barh([1.0, 2.0], [4.0, -9.0], color=INK),
        lambda axis: axis.errorbar([1.0, 2.0], [4.0, 9.0], [0.5, 2.0], color=INK),
        lambda axis: axis.fill_between([1.0, 2.0], [4.0, 9.0], [5.0, 2.0], color=INK),
    ],
)
def test_marks_have_the_room_about_them_that_matplotlib_gives(draw):
    from matplotlib.figure import Figure as Drawing

    ours, theirs = Figure().subplots(), Drawing().subplots()
    draw(ours)
    draw(theirs)
    assert ours.limits("x") == pytest.approx(theirs.get_xlim(), rel=1e-9)
    assert ours.limits("y") == pytest.approx(theirs.get_ylim(), rel=1e-9)


@pytest.mark.parametrize(
    "text",
    ["yaw rate r L / U₀ [-]", "drift angle β midship [deg]", "Fn 0.217, rudder +35°", "95 %"],
)
def test_texts_are_as_wide_as_their_letters(text):
    """Against the font itself, as FreeType has it."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import TextPath

    drawn = TextPath((0, 0), text + ".", size=100, prop=FontProperties(family="DejaVu Sans"))
    dot = TextPath((0, 0), ".", size=100, prop=FontProperties(family="DejaVu Sans"))
    behind = drawn.get_extents().x1 - dot.get_extents().x1
    assert width_of(text, 100.0) == pytest.approx(behind, rel=0.01)


@given(st.lists(st.tuples(st.floats(-500, 500), st.floats(-500, 500)), min_size=2, max_size=60))
@settings(max_examples=200, deadline=None)
def test_a_thinned_line_runs_where_it_ran(points):
    line = np.array(points)
    kept = thinned(line)
    np.testing.assert_array_equal(kept[[0, -1]], line[[0, -1]])
    begin, end = kept[:-1], kept[1:]
    for point in line:
        along = end - begin
        size = np.maximum((along**2).sum(axis=1), 1e-12)
        share = np.clip(((point - begin) * along).sum(axis=1) / size, 0.0, 1.0)
        off = np.hypot(*(begin + share[:, None] * along - point).T)
        assert off.min() < 0.13


def test_a_straight_record_needs_few_points():
    t = np.linspace(0.0, 500.0, 6401)
    assert len(thinned(np.stack([t, 0.3 * t], axis=1))) < 150


def crowded():
    """Long names, powers of ten, symbols, shared sides, several lines."""
    figure = Figure(height=4.6)
    grid = figure.subplots(2, 3, sharex=True)
    t = np.linspace(0.0, 1000.0, 50)
    for number, axis in enumerate(grid.ravel()):
        axis.plot(t, 10.0 ** (4 * number - 8) * np.sin(t), color=INK, label=f"run {number}" * 4)
        axis.set_title(f"a long title of panel {number} which has no room, $Y'_{{v|v|}}$ [N]")
    for axis in grid[1]:
        axis.set_xlabel("time from the first order of the rudder to its last [s]")
    grid[0, 0].set_ylabel("force\nof the water [N]")
    figure.suptitle("of one campaign")
    figure.supylabel("what is left [N]")
    figure.legend_below(list(grid.ravel()), columns=5)
    return figure


def test_no_text_covers_another_or_leaves_the_figure():
    scene = laid_out(crowded())
    boxes = [(own.text, own.box) for own in scene.letters]
    for (one, a), (other, b) in itertools.combinations(boxes, 2):
        apart = (
            a.right <= b.left + 0.8
            or b.right <= a.left + 0.8
            or a.bottom <= b.top + 2.2
            or b.bottom <= a.top + 2.2
        )
        assert apart, (one, other)
    for text, box in boxes:
        assert box.left >= -0.5, text
        assert box.right <= scene.width + 0.5, text
        assert box.top >= -0.5, text
        assert box.bottom <= scene.height + 0.5, text


@given(st.floats(-100.0, 100.0), st.floats(0.1, 100.0), st.floats(2.5, 9.0))
@settings(max_examples=100, deadline=None)
def test_numbers_of_an_abscissa_stand_apart(low, span, width):
    figure = Figure(height=2.0, width=width)
    axis = figure.subplots()
    axis.set_xlim(low, low + span)
    axis.set_yticks([])
    boxes = [own.box for own in laid_out(figure).letters]
    assert len(boxes) > 1
    for one, other in itertools.pairwise(boxes):
        assert one.right + 4.0 < other.left


def test_axes_of_a_column_begin_and_end_alike():
    scene = laid_out(crowded())
    for column in range(3):
        above, below = scene.frames[column].box, scene.frames[column + 3].box
        assert (above.left, above.right) == (below.left, below.right)
    assert all(frame.box.bottom < scene.legend.top for frame in scene.frames)


def test_one_scale_for_both_sides():
    figure = Figure(height=5.0, width=4.0)
    axis = figure.subplots()
    axis.plot([0.0, 3.0], [0.0, 1.0], color=INK)
    axis.set_aspect_equal()
    (frame,) = laid_out(figure).frames
    across = (frame.x[1] - frame.x[0]) / frame.box.width
    assert across == pytest.approx((frame.y[1] - frame.y[0]) / frame.box.height)
    x = frame.across(np.array([0.0, 3.0]))
    assert frame.box.left < x[0] < x[1] < frame.box.right


@given(st.text(max_size=30))
@settings(max_examples=150, deadline=None)
def test_whatever_a_run_is_called_its_figure_is_xml(name):
    from pmmkit.presentation import figure_text

    figure = Figure(height=2.0)
    axis = figure.subplots()
    axis.plot([0, 1], [0, 1], color=INK, label=figure_text(name))
    axis.set_title(figure_text(name))
    figure.legend_below([axis])
    ET.fromstring(figure.svg().encode("utf-8"))


def test_symbols_are_written_with_their_indices():
    figure = Figure(height=2.0)
    figure.subplots().set_title(r"$10^3\,Y'_{\dot{v}}$ [-]")
    texts = [own for own in ET.fromstring(figure.svg()).iter(f"{SPACE}text") if len(own)]
    (title,) = texts
    assert "".join(title.itertext()) == "103\u2009Y′v\u0307 [-]"
    shifts = [float(own.get("dy", 0.0)) for own in title]
    assert sum(shifts) == pytest.approx(0.0, abs=0.02)


def test_figures_of_one_page_do_not_share_what_differs():
    found = []
    for height in (2.0, 3.0, 2.0):
        figure = Figure(height=height)
        figure.subplots().plot([0, 1], [0, 1], color=INK)
        found.append(dict(re.findall(r'id="([^"]+)">(.*)</clipPath>', figure.svg())))
    one, other, same = found
    assert one
    assert not {*one} & {*other}
    assert one == same


def test_cells_have_the_colours_of_their_values():
    shades = Shades(levels=(-1.0, 1.0), colours=RED_BLUE, smooth=True)
    assert shades.of(np.array([-1.0, 0.0, 1.0, 5.0])) == [
        RED_BLUE[0],
        RED_BLUE[5],
        RED_BLUE[-1],
        RED_BLUE[-1],
    ]
    steps = Shades(levels=(0.0, 1.0, 2.0, 1e9), colours=("#000000", "#111111", "#222222"))
    assert steps.of(np.array([0.5, 1.0, 7.0])) == ["#000000", "#111111", "#222222"]


@given(st.floats(60.0, 400.0))
@settings(max_examples=200, deadline=None)
def test_a_title_that_has_room_in_smaller_letters_is_not_cut(room):
    title = Title(text="heading, simulated less measured [deg]", size=10.0)
    own = fitted(title, room)
    assert width_of(own.text, own.size) <= room + 1e-6
    assert (own.text == title.text) == (own.size > 6.5 or room >= width_of(title.text, 6.5))


@pytest.mark.parametrize("value", [np.nan, np.inf, 0.0, 1e300, -1e-300])
@pytest.mark.parametrize("scale", ["linear", "log", "symlog"])
def test_values_that_cannot_be_shown_do_no_harm(value, scale):
    own = np.full(3, value)
    figure = Figure(height=8.0)
    axes = figure.subplots(8, 1)
    axes[0].plot(own, own, color=INK, marker="s", label="line")
    axes[1].errorbar(own, [1.0, 2.0, 3.0], own, own, color=INK, capsize=2)
    axes[2].bar(range(3), own, color=INK, yerr=np.abs(own))
    axes[3].barh(range(3), own, color=INK)
    axes[4].fill_between(range(3), own, own, color=INK)
    axes[5].hlines(own, own, own, color=INK)
    axes[6].mosaic(own[None], Shades(levels=(-1.0, 1.0), colours=RED_BLUE, smooth=True))
    axes[7].polygons(np.stack([own, own], axis=1), color=INK)
    for axis in axes:
        axis.set_xscale(scale, linthresh=1.0)
    text = figure.svg()
    ET.fromstring(text.encode())
    assert not re.search(r'="[^"]*(nan|inf)', text.split("<rect", 1)[1])


@pytest.mark.parametrize(
    "draw",
    [
        lambda axis, **look: axis.plot([0, 1], [0, 1], **look),
        lambda axis, **look: axis.hlines(0.0, 0.0, 1.0, **look),
        lambda axis, **look: axis.axvline(0.0, **look),
        lambda axis, **look: axis.axhspan(0.0, 1.0, **look),
        lambda axis, **look: axis.fill_between([0, 1], 0.0, 1.0, **look),
        lambda axis, **look: axis.bar([0, 1], [0, 1], **look),
    ],
)
def test_no_word_of_how_a_mark_looks_is_passed_over(draw):
    axis = Figure().subplots()
    for wrong in ({"linewidth": 2.0}, {"colour": INK}, {"markeredgewidths": 1.0}):
        with pytest.raises(TypeError, match=f"has no {next(iter(wrong))}"):
            draw(axis, color=INK, **wrong)
    assert not axis.marks


def test_axes_of_one_side_have_the_same_ends_and_ticks():
    figure = Figure()
    grid = figure.subplots(1, 3, sharey=True)
    for number, axis in enumerate(grid, 1):
        axis.plot([0, 1], [0, number], color=INK)
        axis.set_ylim(0.0, float(number))
    grid[0].set_yticks([0.0, 3.0], ["none", "all"])
    frames = laid_out(figure).frames
    assert {frame.y for frame in frames} == {(0.0, 3.0)}
    assert {frame.yticks.at for frame in frames} == {(0.0, 3.0)}
    assert [own.text for own in laid_out(figure).letters].count("all") == 1


def test_polygons_that_turn_against_each_other_leave_no_hole():
    square = np.array([(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)])
    figure = Figure(height=3.0, width=3.0)
    figure.subplots().polygons(np.stack([square, square[::-1] + 1.0]), color=INK)
    (fill,) = (shape for shape in laid_out(figure).shapes if isinstance(shape, Fill))
    edges = [np.diff(ring, axis=0, append=ring[:1]) for ring in fill.rings]
    turns = [x * np.roll(y, -1) - y * np.roll(x, -1) for x, y in (edge.T for edge in edges)]
    assert len({bool(np.all(turn > 0)) for turn in turns}) == 1


@pytest.mark.slow
def test_a_picture_shows_the_line_where_the_figure_has_it(tmp_path):
    """The dark dots of the picture lie on the line, as the layout places it."""
    from matplotlib.image import imread

    figure = Figure(height=3.0, width=4.0)
    axis = figure.subplots()
    axis.plot([0.0, 1.0], [0.0, 1.0], color="#000000", lw=3.0)
    axis.without_grid()
    axis.without_frame()
    axis.set_xticks([])
    axis.set_yticks([])
    picture = imread(figure.save(tmp_path / "line.png"))[..., :3].mean(axis=2)
    rows, columns = np.nonzero(picture < 0.2)
    (frame,) = laid_out(figure).frames
    box, dots = frame.box, 150 / 72
    share = (columns / dots - box.left) / box.width
    x0, x1 = frame.x
    y = frame.upright(x0 + share * (x1 - x0)) * dots
    assert len(rows) > 1000
    assert np.abs(rows - y).max() < 6.0


def test_a_figure_is_a_file_of_three_kinds(tmp_path):
    figure = Figure(height=2.0)
    figure.subplots().plot([0, 1], [0, 1], color=INK)
    starts = {"svg": b"<?xml", "png": b"\x89PNG", "pdf": b"%PDF"}
    for ending, start in starts.items():
        made = [figure.save(tmp_path / f"{n}.{ending}").read_bytes() for n in range(2)]
        assert made[0].startswith(start)
        assert made[0] == made[1]
    with pytest.raises(DataError, match=r"\.svg, \.png or \.pdf"):
        figure.save(tmp_path / "line.jpeg")
