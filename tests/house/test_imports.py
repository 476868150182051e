"""What importing pmmkit costs, and that its short names lead somewhere."""

from __future__ import annotations

import ast
import importlib
import subprocess
import sys
from pathlib import Path

import pytest

import pmmkit

HEAVY = (
    "pandas",
    "xarray",
    "scipy.stats",
    "scipy.signal",
    "matplotlib",
    "h5netcdf",
    "h5py",
    "pydantic",
    "rich",
    "typer",
    "pysindy",
    "sklearn",
    "openpyxl",
    "numba",
    "jinja2",
)


def loaded_by(code: str) -> set[str]:
    """The modules that a fresh interpreter holds after some code."""
    show = f"{code}\nimport sys\nprint(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", show], capture_output=True, text=True, check=True)
    return set(done.stdout.split())


def heavy_among(modules: set[str]) -> list[str]:
    return [name for name in HEAVY if name in modules]


def test_importing_pmmkit_loads_nothing_heavy():
    assert heavy_among(loaded_by("import pmmkit")) == []


@pytest.mark.slow
def test_every_short_name_is_reached_without_plotting_or_statistics():
    modules = loaded_by("import pmmkit\nfor name in pmmkit.__all__: getattr(pmmkit, name)")
    assert heavy_among(modules) == []


@pytest.mark.slow
@pytest.mark.parametrize(
    "module", ["pmmkit.views.figures", "pmmkit.views.report", "pmmkit.api", "pmmkit.reduction"]
)
def test_rooms_load_heavy_packages_only_when_used(module):
    assert heavy_among(loaded_by(f"import {module}")) == []


def test_figures_are_drawn_without_matplotlib():
    code = """from pmmkit.plotting import *
axis = (figure := Figure()).subplots()
axis.plot([0, 1], [0, 1], color="#000000", label="both")
figure.legend_below([axis])
assert "both" in figure.svg()"""
    assert heavy_among(loaded_by(code)) == []


def test_the_command_line_loads_typer_and_nothing_else_heavy():
    modules = loaded_by("from pmmkit.cli.app import application\napplication()")
    assert {"pmmkit.actions.jobs.demo", "pmmkit.actions.jobs.trial"} <= modules
    assert set(heavy_among(modules)) <= {"typer", "rich"}
    assert "numpy" not in modules


@pytest.mark.parametrize("name", pmmkit.__all__)
def test_short_names_are_the_objects_of_their_rooms(name):
    thing = getattr(pmmkit, name)
    if callable(thing):
        home = importlib.import_module(thing.__module__)
        assert getattr(home, thing.__name__) is thing


def test_a_wrong_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="reduse"):
        _ = pmmkit.reduse


def test_dir_shows_the_public_words_and_nothing_else():
    assert len(set(pmmkit.__all__)) == len(pmmkit.__all__) > 60
    assert dir(pmmkit) == sorted(pmmkit.__all__)


def test_type_checkers_and_editors_see_each_word():
    tree = ast.parse(Path(pmmkit.__file__).read_text("utf-8"))
    (block,) = (node for node in tree.body if isinstance(node, ast.If))
    assert ast.unparse(block.test) == "TYPE_CHECKING"
    seen = [word.name for line in block.body for word in line.names]
    assert sorted(seen) == sorted(pmmkit.__all__)
