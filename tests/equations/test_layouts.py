"""Places and kinds have names: moving one moves both who fills it and who reads it."""

from __future__ import annotations

import ast
import os
import re
import subprocess
import sys
from enum import EnumType, IntEnum
from pathlib import Path

import pytest

from pmmkit.equations import layouts

EQUATIONS = Path(layouts.__file__).parent
LAYOUTS = [x for x in vars(layouts).values() if isinstance(x, EnumType) and x is not IntEnum]
LISTS = frozenset(
    ("k", "gear", "phases", "settings", "probes", "events", "outcomes", "inputs", "out")
)
INNER = LISTS | {"base", "start", "stop", "y", "z", "new", "h", "found", "size", "states"}
KINDS = frozenset(("kind", "kinds", "status", "c", "which", "watched"))

OTHER_LAYOUTS = """
import ast, sys, types
from importlib.util import find_spec
from pathlib import Path

def turned(by):
    return lambda names: [*names[by:], *names[:by]]

def with_more(names):
    return [ast.Constant("nothing"), *names[:26], ast.Constant("none"), *names[26:]]

REORDERED = ("GearField", "ProbeField", "StepField", "OutcomeField", "InputField")
DISTURBED = {
    "Constant": with_more,
    **{name: turned(3) for name in ("PhaseField", "SettingField", "Status")},
    "EventField": turned(4),
    **{name: turned(-1) for name in (*REORDERED, "End", "Ask", "OverGround")},
}
file = Path(find_spec("pmmkit").origin).parent / "equations" / "layouts.py"
tree = ast.parse(file.read_text(encoding="utf-8"))
for node in tree.body:
    if isinstance(node, ast.Assign) and node.targets[0].id in DISTURBED:
        names = node.value.args[1]
        names.elts = DISTURBED.pop(node.targets[0].id)(names.elts)
assert not DISTURBED, DISTURBED
module = types.ModuleType("pmmkit.equations.layouts")
exec(compile(ast.fix_missing_locations(tree), str(file), "exec"), module.__dict__)
sys.modules[module.__name__] = module
"""
RESULTS = """
import hashlib
import numpy as np
import pmmkit as pk
from pmmkit.equations import prepare
from pmmkit.equations.code_generation import ESTIMATING
from pmmkit.equations.compilation import compiled
from pmmkit.identification import FreeRecord, identify
from pmmkit.models import load_model
from pmmkit.simulation import monte_carlo

def told(name, *values):
    digest = hashlib.sha256()
    for value in values:
        digest.update(np.ascontiguousarray(np.asarray(value, float)).tobytes())
    print("result", name, digest.hexdigest())

def told_track(name, track):
    told(name, *(getattr(track, x) for x in ("t", "x", "y", "psi", "u", "v", "r", "delta", "n")),
         *track.metrics.values())

told_track("wind", pk.simulate("s175", speed=9.0, compiled=False, wind_speed=12.0,
                               wind_direction_deg=60.0, current_speed=0.5))
told_track("stopping", pk.simulate("kvlcc2-l7", "stopping", speed=1.179, compiled=False))
told_track("spiral", pk.simulate("kvlcc2-l7", "spiral", speed=1.179, compiled=False, step_deg=10.0))
turn = pk.simulate("kvlcc2-l7", speed=1.179)
told_track("turn", turn)
told_track("turn, interpreted", pk.simulate("kvlcc2-l7", speed=1.179, compiled=False))
zigzag = pk.simulate("kvlcc2-l7", "zigzag", speed=1.179, dt=0.5)
told_track("zigzag", zigzag)
told("many", *monte_carlo("kvlcc2-l7", "zigzag", speed=1.179, n=1, spread=0.05).metrics.values())
measured = {
    "x": zigzag.x, "y": zigzag.y, "psi": zigzag.psi, "sog": np.hypot(zigzag.u, zigzag.v),
    "xdot": zigzag.u * np.cos(zigzag.psi) - zigzag.v * np.sin(zigzag.psi),
}
noise = np.random.default_rng(1).normal(scale=1e-3, size=(len(measured), len(zigzag.t)))
N = 24
record = FreeRecord(
    name="zigzag", t=zigzag.t[:N], delta=zigzag.delta[:N], turns=zigzag.n[:N], speed=1.179,
    measured={name: (x + e)[:N] for (name, x), e in zip(measured.items(), noise, strict=True)},
    wind_speed=np.full(N, 0.3), wind_direction=np.full(N, 1.0),
)
found = identify(load_model("kvlcc2-l7"), [record], ["Yv", "Nr", "current_x"], method="ekf")
told("filter", found.values, found.covariance)
structure = prepare(load_model("kvlcc2-l7"), 1.179).structure
for files in ((structure,), (structure, ESTIMATING)):
    print("module", compiled(*files).__name__)
"""


@pytest.fixture(scope="module")
def outcomes(tmp_path_factory):
    """What the same work prints with the layouts as they are and with others."""

    def said(text, folder):
        done = subprocess.run(
            [sys.executable, "-c", text],
            env=os.environ | {"PMMKIT_CACHE": str(folder), "NUMBA_DISABLE_JIT": "1"},
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        return [line.split() for line in done.stdout.splitlines()]

    folder = tmp_path_factory.mktemp("cache")
    return said(RESULTS, folder), said(OTHER_LAYOUTS + RESULTS, folder)


@pytest.mark.slow
def test_results_do_not_depend_on_where_numbers_stand(outcomes):
    """Constants are inserted before the first and in the middle; kinds and fields are reordered."""
    mine, others = outcomes
    results = [line for line in mine if line[0] == "result"]
    assert len(results) == 8
    assert results == [line for line in others if line[0] == "result"]


@pytest.mark.slow
def test_compiled_equations_of_other_layouts_are_other_modules(outcomes):
    mine, others = ({line[1] for line in lines if line[0] == "module"} for lines in outcomes)
    assert len(mine) == len(others) == 2
    assert not mine & others


def literals(node):
    """Whole numbers in an expression, but those that count rows."""
    match node:
        case ast.BinOp(op=ast.Mult()) | ast.BinOp(left=ast.Name("t")) | ast.JoinedStr():
            return []
        case ast.Constant(value=int(value)):
            return [value]
    return [value for child in ast.iter_child_nodes(node) for value in literals(child)]


def numbers_for_names(source, lists=INNER):
    """Lines where a whole number stands for a place in a list, or for a kind."""
    found = []
    for node in ast.walk(ast.parse(source)):
        match node:
            case ast.Subscript(value=ast.Name(id=name)) if name in lists and literals(node.slice):
                found.append(ast.unparse(node))
            case ast.Subscript(value=ast.Attribute(attr="k")) if literals(node.slice):
                found.append(ast.unparse(node))
            case ast.Compare(left=ast.Name(id=name)) if name in KINDS and literals(node):
                found.append(ast.unparse(node))
            case ast.Constant(value=str(text)):
                found += re.findall(r"\b(?:k|y|out)\[-?\d+\]", text)
    return found


@pytest.mark.parametrize(
    "line",
    ["mass = k[3]", "gear[g + 1] = n0", "if kind == 2: pass", "a = ready.k[6]", "b = 'k[26] * X'"],
)
def test_a_number_for_a_name_is_seen(line):
    assert len(numbers_for_names(line)) == 1


@pytest.mark.parametrize("name", sorted(path.name for path in EQUATIONS.glob("*.py")))
def test_no_number_stands_for_a_name_in_the_equations(name):
    assert numbers_for_names((EQUATIONS / name).read_text(encoding="utf-8")) == []


def test_no_number_stands_for_a_name_where_layouts_are_used():
    package = EQUATIONS.parent
    users = [
        path
        for path in package.rglob("*.py")
        if "pmmkit.equations.layouts" in path.read_text(encoding="utf-8")
    ]
    assert len(users) > 10
    for path in users:
        assert numbers_for_names(path.read_text(encoding="utf-8"), LISTS) == [], path


@pytest.mark.parametrize("layout", LAYOUTS, ids=lambda layout: layout.__name__)
def test_places_of_a_layout_lie_side_by_side(layout):
    places = [int(member) for member in layout]
    assert places == list(range(places[0], places[0] + len(places)))


@pytest.mark.parametrize(
    ("layout", "end"),
    [
        (layouts.PhaseField, ""),
        (layouts.EventField, ""),
        (layouts.EventField, "_order"),
        (layouts.SettingField, "_rate"),
        (layouts.SettingField, "_lag"),
        (layouts.InputField, ""),
    ],
)
def test_controls_lie_side_by_side_in_their_order(layout, end):
    first = layout[f"{layouts.Control(0).name}{end}"]
    places = [layout[f"{control.name}{end}"] - first for control in layouts.Control]
    assert places == list(layouts.Control)


def test_a_kind_over_ground_is_no_state():
    assert min(layouts.OverGround) > 10 * len(layouts.State)
