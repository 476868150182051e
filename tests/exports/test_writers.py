"""The same function in every language gives the same numbers: Python's own arithmetic is the judge.

MATLAB is read by an interpreter that knows nothing of pmmkit (`matlab_arithmetic`).
"""

from __future__ import annotations

import ctypes
import inspect
import math
import shutil
import subprocess
from types import ModuleType

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matlab_arithmetic import evaluated

import pmmkit as pk
from pmmkit.effects.primitives import (
    atan2,
    cos,
    exp,
    fabs,
    maximum,
    minimum,
    pi,
    sin,
    sqrt,
    tanh,
    where,
)
from pmmkit.exports.matlab.model import model_to_mss
from pmmkit.syntax import CProgram, Unwritable, expression, transcribe
from pmmkit.syntax.matlab.transcribe import printed

COMPILER = shutil.which("cc")
LARGE, SMALL = 1e308, 5e-324
POINTS = [
    (1.5, -0.5, 2.0),
    (-2.0, 3.0, 0.7),
    (-0.3, 0.5, -0.25),
    (0.0, -0.0, 1.0),
    (2.0, 2.0, 3.0),
    (-1.0, -2.0, -3.0),
]


def power_then_sign(a, b, c):
    return (-(a**2) + (-a) ** 3 + -(b**2) * c,)


def power_of_a_sign(a, b, c):
    return (2.0**-a + 2**-1 * b + (1.0 + c * c) ** -2,)


def powers_in_a_row(a, b, c):
    return (2.0**a**2 - (2.0**a) ** 2 + (a**2) ** 3,)


def differences(a, b, c):
    return (a - (b - c) - (a + b) - -c - (-b) + (+a),)


def quotients(a, b, c):
    return (a / (2.0 + b * b) / (c / 3.0) - 7 / 2 * a - 1 / 3 - a * b / -c,)


def signs(a, b, c):
    return (-(a - b) * -c - -a * -b + -(a * b) / c,)


def moduli(a, b, c):
    return (fabs(a) * abs(b) - math.fabs(c),)


def larger_and_smaller(a, b, c):
    return (maximum(a, b) - minimum(b, c) + max(a, b, c) * min(a, 1.0, c),)


def sign_of(a, b, c):
    return (where(a > 0.0, 1.0, where(a < 0.0, -1.0, 0.0)),)


def chains(a, b, c):
    return (where(a < b < c, 1.0, 2.0) + (3.0 if a != b >= c else 4.0),)


def comparisons_of_comparisons(a, b, c):
    return (where((a < b) == (b < c), 1.0, 2.0),)


def logic(a, b, c):
    return (where(not a > 0.0 or (b > 0.0 and c < 1.0), 1.0, 2.0) + where(not (a > b), 1.0, 0.0),)


def truths_as_numbers(a, b, c):
    return (a * (b < c) + (a < b) - -(a > 0.5),)


def angles(a, b, c):
    return (atan2(a, b) + math.atan2(-a, -b) + sin(pi * a) * cos(math.pi * b) - tanh(c),)


def large_and_small(a, b, c):
    return (
        a * 1e-320 * 1e300 + LARGE * a * 1e-300 + SMALL * a + 1e16 * b + 123456789012345680 * c,
    )


def negative_zero(a, b, c):
    return (math.atan2(-0.0 * fabs(a), -1.0) + math.atan2(-a * 0.0, -1.0),)


def library(a, b, c):
    one = sqrt(fabs(a)) + exp(-b) + math.log(fabs(c) + 1.0) + math.hypot(a, b)
    two = math.tan(a) + math.asin(0.3) + math.sinh(b) + math.floor(a) - math.ceil(b)
    return (one - two + int(a) + float(b),)


def own_words(a, b, c):
    a, b = b, a
    a += b
    a *= c
    return (_scaled(a) - _scaled(b, by=c) + _scaled(x=c),)


def _scaled(x, by=2.5):
    return x * by if by > 0.0 else -x


def whole_products(a, b, c):
    return (1000000 * 1000000 * a + (2147483647 + 1),)


FUNCTIONS = [
    power_then_sign, power_of_a_sign, powers_in_a_row, differences, quotients, signs, moduli,
    larger_and_smaller, sign_of, chains, comparisons_of_comparisons, logic, truths_as_numbers,
    angles, large_and_small, negative_zero, library, own_words, whole_products,
]  # fmt: skip


def in_matlab(function, point) -> float:
    lines, (last,) = transcribe(function, {"a": "a", "b": "b", "c": "c"}, "own")
    known = dict(zip("abc", point, strict=True))
    for line in lines:
        known[line.target] = evaluated(printed(line.value), known)
    return float(evaluated(printed(last), known))


@pytest.mark.parametrize("function", FUNCTIONS, ids=lambda x: x.__name__)
def test_matlab_gives_what_python_gives(function):
    for point in POINTS:
        assert in_matlab(function, point) == pytest.approx(float(function(*point)[0]), rel=1e-15)


@pytest.mark.skipif(COMPILER is None, reason="there is no C compiler cc")
def test_c_gives_what_python_gives(tmp_path):
    module = ModuleType("functions")
    vars(module).update({item.__name__: item for item in FUNCTIONS})
    program = CProgram("", module)
    calls = [
        f"double run_{x.__name__}(double a, double b, double c)"
        f" {{ return {program.take(x.__name__, ['double'] * 3)}(a, b, c); }}"
        for x in FUNCTIONS
    ]
    text = "\n".join(["#include <math.h>", program.text, *calls])
    (tmp_path / "p.c").write_text(text, encoding="utf-8")
    options = ["-std=c99", "-O2", "-ffp-contract=off", "-fPIC", "-shared"]
    subprocess.run([COMPILER, *options, "-o", "p.so", "p.c", "-lm"], cwd=tmp_path, check=True)
    made = ctypes.CDLL(str(tmp_path / "p.so"))
    for item in FUNCTIONS:
        run = getattr(made, f"run_{item.__name__}")
        run.restype, run.argtypes = ctypes.c_double, [ctypes.c_double] * 3
        for point in POINTS:
            wanted = float(item(*point)[0])
            assert run(*point) == pytest.approx(wanted, rel=1e-15), item.__name__


@pytest.mark.parametrize("function", FUNCTIONS, ids=lambda x: x.__name__)
def test_machine_code_gives_what_python_gives(function):
    numba = pytest.importorskip("numba")
    from pmmkit.equations.machine_code import written

    module = ModuleType("functions")
    module.function = function
    made = written(lambda: ({}, module), f"{function.__name__}.")("function")
    called = numba.njit(lambda a, b, c: made((a, b, c)))
    for point in POINTS:
        assert called(*point) == pytest.approx(float(function(*point)[0]), rel=1e-15)


_LEAVES = st.sampled_from(("a", "b", "c", "2.0", "0.5", "3"))
_TEXTS = st.recursive(
    _LEAVES,
    lambda inner: st.one_of(
        st.tuples(inner, st.sampled_from("+-*/"), inner).map(lambda x: f"({x[0]}{x[1]}{x[2]})"),
        st.tuples(inner, st.sampled_from("23")).map(lambda x: f"({x[0]})**{x[1]}"),
        inner.map(lambda x: f"(-{x})"),
        inner.map(lambda x: f"fabs({x})"),
        st.tuples(inner, inner).map(lambda x: f"min({x[0]}, {x[1]})"),
    ),
    max_leaves=10,
)


@settings(deadline=None)
@given(text=_TEXTS)
def test_any_formula_in_matlab_has_the_value_of_python(text):
    known = {"a": 1.7, "b": -0.3, "c": 2.6, "fabs": abs}
    try:
        wanted = eval(text, dict(known))
    except (ZeroDivisionError, OverflowError):
        return
    assert evaluated(printed(expression(text)), known) == pytest.approx(wanted, rel=1e-14)


# --- What cannot be written is said --------------------------------------------------------------


def _unknown(a, b, c):
    return (math.copysign(a, b),)


def _remainder(a, b, c):
    return (a % b,)


def _loop(a, b, c):
    while a > 0.0:
        a -= 1.0
    return (a,)


def _branch(a, b, c):
    if a > b:
        return (a,)
    return (b,)


def _no_number(a, b, c):
    return (open(a),)


def _table(a, b, c):
    return (POINTS[0][0] * a,)


def _two_arguments(a, b, c):
    return (math.log(a, b),)


def _left_out(a, b, c):
    return (_needing(a),)


def _needing(x, y):
    return x * y


@pytest.mark.parametrize(
    ("function", "why"),
    [
        (_unknown, "the function copysign"),
        (_remainder, "without an equivalent"),
        (_loop, "a loop"),
        (_branch, "a branch that depends on the motion"),
        (_no_number, "the function open"),
        (_table, "a table of its own"),
        (_two_arguments, "the function log"),
        (_left_out, "leaves an argument out"),
    ],
)
def test_what_matlab_is_not_written_for_is_said(function, why):
    with pytest.raises(Unwritable, match=why):
        transcribe(function, {"a": "a", "b": "b", "c": "c"}, "own")


# --- Own effects from text -----------------------------------------------------------------------

OWN = {
    "fins": "Y: a*v*|v|*Fn; N: -0.4*a*v*|v|*Fn; a ~ -0.01",
    "awkward": "Y: a*(-v^2 - (r - (u - beta)) / (2*(1.5*Fn))) - -a*beyond(v, 0.1)*|r|^3*exp(-Fn)"
    "*min(v, r)*max(beta, d)*sat(r, 0.2) + a*sqrt(v)*cos(phi)*tanh(r)*sin(p); a ~ 1e-3",
}


@pytest.mark.parametrize("name", OWN)
def test_an_effect_from_text_is_written_for_matlab(name):
    """The text by Python's own arithmetic, and the lines of the exported file."""
    effect = pk.own_effect(name, OWN[name])
    model = pk.with_effect(pk.load_model("s175"), effect, coefficients="typical")
    lines = model_to_mss(model, speed=8.0).split("\nend\n")[0].replace(" ...\n", " ").splitlines()
    own = [line.split(";")[0] for line in lines if line.startswith((f"{name}_", "Y = Y + "))]
    for place in range(4):
        motion = {"u": 7.0, "v": 0.9 - 0.6 * place, "r": 0.02 * (place - 1), "p": 0.01, "d": 9.0}
        known = {**motion, "U": 7.1, "L": 175.0, "rho": 1025.0, "phi": 0.1, "beta": -0.1}
        known |= {"Fn": 0.17, "delta": 0.3, "Y": 0.0}
        asked = inspect.signature(effect.force).parameters
        a = dict(effect.typical)["a"]
        wanted = effect.force(**{x: a if x == "a" else known[x] for x in asked})[0]
        for line in own:
            target, text = line.split(" = ")
            if f"{name}_" in line:
                known[target] = evaluated(text, known)
        assert known["Y"] == pytest.approx(wanted, rel=1e-14)
        assert known["Y"] == pytest.approx(_by_hand(name, known, a), rel=1e-13)


def _by_hand(name, m, a):
    """The formulas of `OWN` once more, written down for Python."""
    v, r, u, p = (
        m["v"] / m["U"],
        m["r"] * m["L"] / m["U"],
        m["u"] / m["U"],
        m["p"] * m["L"] / m["U"],
    )
    unit, Fn, beta, d = 0.5 * m["rho"] * m["L"] ** 2 * m["U"] ** 2, m["Fn"], m["beta"], m["delta"]
    if name == "fins":
        return unit * a * v * abs(v) * Fn
    within, less = max(min(v, 0.1), -0.1), max(min(r, 0.2), -0.2)
    first = a * (-(v**2) - (r - (u - beta)) / (3.0 * Fn))
    second = a * (v - within) * abs(r) ** 3 * math.exp(-Fn) * min(v, r) * max(beta, d) * less
    third = a * math.sqrt(max(v, 0.0)) * math.cos(m["phi"]) * math.tanh(r) * math.sin(p)
    return unit * (first + second + third)
