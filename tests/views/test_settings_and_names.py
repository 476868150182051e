"""Figures look the same under any settings of matplotlib, and show any name as it is."""

from __future__ import annotations

import os
import subprocess
import sys
import xml.etree.ElementTree as ET
from dataclasses import replace

import matplotlib as mpl
import pytest
from pages import answers_in, texts_in
from small_campaign import write_campaign

import pmmkit as pk
from pmmkit.cli import main
from pmmkit.plotting.raster import plain
from pmmkit.plotting.time_series import zigzag
from pmmkit.views.figures.inspecting import columns_over_time
from pmmkit.views.report.build import page_file, reduction_answers

ODD = {
    "text.usetex": True,
    "text.parse_math": False,
    "axes.grid": False,
    "font.family": ["a font that nobody has"],
    "mathtext.fontset": "custom",
    "figure.figsize": [1.0, 1.0],
    "figure.autolayout": True,
    "savefig.bbox": "tight",
    "savefig.format": "pdf",
    "svg.fonttype": "none",
    "axes.prop_cycle": mpl.cycler(color=["k"], linestyle=["none"]),
    "axes.xmargin": 0.4,
    "lines.marker": "x",
    "path.sketch": (5.0, 10.0, 2.0),
    "axes.unicode_minus": False,
    "axes.formatter.use_locale": True,
    "hist.bins": 3,
    "legend.loc": "center",
}
MATHS = r"$\frac{$ costs 5 $ and $\nonsense$"


@pytest.fixture(scope="module")
def track():
    return pk.simulate("kvlcc2-l7", speed=1.2, compiled=False)


def test_a_figure_is_the_same_to_the_byte_under_odd_settings(track):
    figure = track.plot()
    plainly = figure.svg(), figure.png(50)
    with mpl.rc_context(ODD):
        before = dict(mpl.rcParams)
        figure = track.plot()
        assert (figure.svg(), figure.png(50)) == plainly
        assert dict(mpl.rcParams) == before


def test_where_figures_are_shown_is_the_sessions_affair():
    with mpl.rc_context({"interactive": True, "timezone": "Europe/Berlin"}), plain():
        assert mpl.rcParams["interactive"]
        assert mpl.rcParams["timezone"] == "Europe/Berlin"


@pytest.mark.slow
def test_a_command_writes_its_figures_with_latex_asked_for_and_none_installed(tmp_path):
    settings = tmp_path / "matplotlibrc"
    settings.write_text("text.usetex: True\nfont.family: serif\nno.such.key: 1\n")
    environment = {**os.environ, "MATPLOTLIBRC": str(settings), "PATH": ""}
    asked = ["simulate", "kvlcc2-l7", "--speed", "1.2", "--out", str(tmp_path / "out")]
    done = subprocess.run(
        [sys.executable, "-m", "pmmkit", *asked],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "<svg" in (tmp_path / "out" / "trajectory.svg").read_text(encoding="utf-8")


def test_a_dollar_is_a_dollar(track):
    for figure in (
        zigzag([track], names=[MATHS]),
        columns_over_time(track.t, {MATHS: track.u}, time_label=MATHS, title=f"{MATHS}.csv"),
    ):
        texts = ["".join(own.itertext()) for own in ET.fromstring(figure.svg())]
        assert any(MATHS in text for text in texts)


@pytest.mark.slow
def test_a_report_of_runs_with_mathematics_in_their_names(tmp_path):
    campaign = pk.open_campaign(write_campaign(tmp_path / "small"))
    evil = f"--><script>alert(1)</script>{MATHS}"
    runs = tuple(replace(run, id=f"{run.id} {evil}") for run in campaign.runs)
    reduction = pk.reduce_campaign(campaign.with_(runs=runs, title=evil))
    html = page_file(reduction_answers(reduction))
    assert html.count("<script") == html.count("</script>") == 3
    assert "<script>alert" not in html
    assert "content-security-policy" in html
    assert evil in texts_in(answers_in(html))


def test_a_ship_with_mathematics_in_its_name_turns(tmp_path):
    model = pk.load_model("kvlcc2-l7").with_(name=MATHS, title=MATHS)
    pk.save_model(model, tmp_path / "model.toml")
    out = ["--out", str(tmp_path / "out")]
    assert main(["simulate", str(tmp_path / "model.toml"), "--speed", "1.2", *out]) == 0


def test_a_notebook_shows_a_figure_without_pyplot(track):
    """A notebook draws what is not pyplot's by the method that the object has for it."""
    figure = track.plot()
    shown = ET.fromstring(figure._repr_svg_())
    width, height = (float(shown.get(side).removesuffix("pt")) for side in ("width", "height"))
    assert width > height > 200
