"""Functions written in C give what they give in Python, and what C is not written for is named."""

from __future__ import annotations

import ctypes
import inspect
import itertools
import math
import random
import shutil
import subprocess
from types import ModuleType

import pytest

import pmmkit as pk
from pmmkit import catalogue
from pmmkit.effects import primitives
from pmmkit.equations import prepare
from pmmkit.syntax import CProgram, Unwritable

COMPILER = shutil.which("cc")
needs_compiler = pytest.mark.skipif(COMPILER is None, reason="there is no C compiler cc")
LENGTH = 4
"""Of every table."""


def program_of(text: str) -> CProgram:
    """A program of functions in the words of effects."""
    module = ModuleType("functions")
    module.__dict__.update({name: getattr(primitives, name) for name in primitives.__all__})
    module.__dict__.update(math=math, vector=lambda size: [0.0] * size)
    exec(text, module.__dict__)
    return CProgram(text, module)


def loaded(text: str, folder) -> ctypes.CDLL:
    """The compiled program."""
    (folder / "program.c").write_text(f"#include <math.h>\n{text}")
    options = ["-std=c99", "-O2", "-ffp-contract=off", "-fPIC", "-shared", "-Wall", "-Werror"]
    allowed = ["-Wno-unused-function", "-Wno-unused-but-set-variable"]
    done = subprocess.run(
        [COMPILER, *options, *allowed, "-o", "program.so", "program.c", "-lm"],
        cwd=folder,
        capture_output=True,
        text=True,
    )
    assert not done.returncode, done.stderr
    return ctypes.CDLL(str(folder / "program.so"))


def numbers(values) -> ctypes.Array:
    return (ctypes.c_double * len(values))(*values)


# --- Every effect of the catalogue ---------------------------------------------------------------


def kinds_of(effect) -> list[str]:
    names = inspect.signature(effect.force).parameters
    return [
        "table" if x in effect.tables else "int" if x in effect.options else "double" for x in names
    ]


def sizes_of(effect) -> list[int]:
    """How many numbers each argument has: a list stands over other lists or alone."""
    return [
        LENGTH ** max(len(effect.parameter(x).over), 1) if x in effect.tables else 1
        for x in inspect.signature(effect.force).parameters
    ]


def called(name: str, sizes: list[int], count: int) -> str:
    """A function that takes all arguments in one list and fills another with what is returned."""
    texts, at = [], 0
    for size in sizes:
        texts.append(f"a + {at}, {size}" if size > 1 else f"a[{at}]")
        at += size
    arguments = ", ".join(texts)
    if count == 1:
        body = f"out[0] = {name}({arguments});"
    else:
        filled = " ".join(f"out[{i}] = found.v{i};" for i in range(count))
        body = f"struct numbers_{count} found = {name}({arguments}); {filled}"
    return f"void call_{name}(const double *a, double *out) {{ {body} }}\n"


@pytest.mark.slow
@needs_compiler
def test_every_effect_is_the_same_in_c(tmp_path):
    effects = [
        item
        for item in catalogue().values()
        if item.enters and item.force and item.force.__module__.startswith("pmmkit.")
    ]
    module = ModuleType("effects")
    vars(module).update({f"effect_{item.name}": item.force for item in effects})
    program, calls = CProgram("", module), []
    for item in effects:
        name = program.take(f"effect_{item.name}", kinds_of(item))
        calls.append(called(name, sizes_of(item), len(item.outputs)))
    library = loaded(program.text + "\n".join(calls), tmp_path)
    rng = random.Random(3)
    assert {"four_quadrant_propeller", "wind", "memory"} <= {item.name for item in effects}
    for item in effects:
        compare(item, getattr(library, f"call_eq_effect_{item.name}"), rng)


def compare(effect, function, rng):
    words = [range(len(choices)) for choices in effect.options.values()]
    compared = 0
    for chosen, _ in itertools.product(itertools.product(*words), range(12)):
        options = dict(zip(effect.options, chosen, strict=True))
        given = [
            options[name]
            if name in options
            else tuple(sorted(rng.uniform(-1.2, 1.2) for _ in range(size)))
            if name in effect.tables
            else rng.uniform(-1.0, 1.0)
            if name in ("v", "r", "p", "phi", "psi", "delta", "beta", "n")
            else rng.uniform(0.1, 1.5)
            for name, size in zip(
                inspect.signature(effect.force).parameters, sizes_of(effect), strict=True
            )
        ]
        try:
            wanted = effect.force(*given)
        except (ZeroDivisionError, ValueError, OverflowError):
            continue
        flat = [x for item in given for x in (item if isinstance(item, tuple) else (item,))]
        found = numbers([0.0] * len(wanted))
        function(numbers(flat), found)
        assert list(found) == pytest.approx(list(wanted), rel=1e-13, abs=1e-300), effect.name
        compared += 1
    assert compared > 3, effect.name


# --- The right-hand sides of the library ---------------------------------------------------------


@pytest.mark.slow
@needs_compiler
@pytest.mark.parametrize("name", ["s175", "kvlcc2", "mariner", "esso190k", "esso-osaka-3m"])
def test_the_equations_of_motion_are_the_same_in_c(name, tmp_path):
    model = pk.load_model(name)
    speed = model.ship.speed(0.15)
    ready = prepare(model, speed)
    program = CProgram(*ready.program())
    moment = ["list", "double", "double", "double", "list", "list"]
    for function, kinds in (("rates", moment), ("complete", ["list"])):
        program.take(function, kinds)
    ends = """
    void rates(double *y, const double *c, double *k, double *out)
    { eq_complete(k); eq_rates(y, c[0], c[1], c[2], k, out); }"""
    library = loaded(program.text + ends, tmp_path)
    rng, states = random.Random(5), ready.structure.states
    for _ in range(50):
        y = [rng.uniform(-0.3, 0.3) for _ in states]
        y[3:6] = [rng.uniform(0.3, 1.1) * speed, y[4] * speed, y[5] * speed / ready.L]
        delta, n = rng.uniform(-0.6, 0.6), rng.uniform(0.5, 2.0)
        out = numbers([0.0] * len(states))
        library.rates(numbers(y), numbers([delta, n, 0.0]), numbers(list(ready.k)), out)
        assert list(out) == pytest.approx(ready.rates(y, delta, n), rel=1e-13, abs=1e-16)


# --- What the words of Python mean ---------------------------------------------------------------


@needs_compiler
def test_words_that_mean_something_else_in_c_keep_their_meaning(tmp_path):
    text = """
def told(a, b):
    short = a if a > b else b
    a, b = b, a
    total = 0
    for i in range(1, 5):
        if i == 2:
            continue
        total += i / 2
    whole = 7 // 2
    room = vector(3)
    room[0], room[1] = a, b
    room[0], room[1] = room[1], room[0]
    while total > 3.5:
        total -= 1.0
    between = 1.0 if 0.0 < a < 2.0 and (1 < 2 or a > 9.0) and not (2 < 1) else 0.0
    if 2 < 1 and room[7] > 0.0:
        between = room[8]
    return short, a - b, total, whole - 1 / 2, room[0] - room[1], between, max(a, b) - min(a, b, 0)
"""
    program = program_of(text)
    name = program.take("told", ["double", "double"])
    library = loaded(program.text + called(name, [1, 1], 7), tmp_path)
    known: dict = {"vector": lambda size: [0.0] * size}
    exec(text, known)
    for a, b in ((1.5, -0.5), (-2.0, 3.0), (0.0, 0.0)):
        found = numbers([0.0] * 7)
        library.call_eq_told(numbers([a, b]), found)
        assert list(found) == list(known["told"](a, b))


@needs_compiler
def test_whole_numbers_of_c_are_those_of_python(tmp_path):
    """Division goes by the floor, and no product or sum grows beyond C's int."""
    text = """
def told(a):
    n = int(a)
    large = 1000000 * 1000000 * a + (2147483647 + 1)
    return n // 2, (n - 7) // 3, n // -3, -7 // 2 + a, large, 2**-1 * a, -(n > 0) + 0.5
"""
    program = program_of(text)
    name = program.take("told", ["double"])
    library = loaded(program.text + called(name, [1], 7), tmp_path)
    known: dict = {}
    exec(text, known)
    for a in (-8.0, -7.5, -1.0, 0.0, 1.0, 6.0, 7.0):
        found = numbers([0.0] * 7)
        library.call_eq_told(numbers([a]), found)
        assert list(found) == list(known["told"](a))


@pytest.mark.parametrize(
    ("body", "why"),
    [
        ("return [x for x in (a, b)][0]", "ListComp"),
        ("return a.real", "Attribute"),
        ("return open(a)", "the function open"),
        ("return unknown * a", "the name 'unknown'"),
        ("return a % b", "%"),
        ("return math.log(a, b)", "the function log"),
        ("for x in (a, b):\n        a = x\n    return a", "For"),
        ("for i in range(3):\n        a = i\n    return i * a", "the name 'i'"),
        ("c = vector(int(a))\n    return c[0]", "length is not known"),
        ("return a or b", "by their truth"),
        ("return (lambda x: x)(a)", "by its name"),
        ("with a:\n        return b", "With"),
        ("return 'text'", "Constant"),
        ("return told(a - 1.0, b)", "calls itself"),
        ("return told(a)", "leaves an argument out"),
    ],
)
def test_what_c_is_not_written_for_is_said(body, why):
    with pytest.raises(Unwritable, match=why):
        program_of(f"def told(a, b):\n    {body}\n").take("told", ["double", "double"])
