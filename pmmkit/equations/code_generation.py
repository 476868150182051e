"""The text of a module with the equations of one structure and the engine that integrates them."""

from __future__ import annotations

import dis
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from enum import EnumType, IntEnum
from functools import cache
from pathlib import Path
from types import FunctionType
from typing import Any, Final

from pmmkit.conventions import CHANNELS
from pmmkit.effects import PRIMITIVES, catalogue, function_of_text, rebound
from pmmkit.equations import layouts
from pmmkit.equations.layouts import (
    ROLLING,
    STATES,
    Constant,
    Control,
    LaneMove,
    LaneSlot,
    State,
    StepField,
)
from pmmkit.equations.structure import ACCELERATIONS, FACTOR_PLACES, EquationStructure, Used
from pmmkit.inference import FILTERS
from pmmkit.syntax import (
    Binary,
    Call,
    Expression,
    Member,
    Name,
    Number,
    Span,
    Subscript,
    functions,
    python_lines,
    statements,
)

MOTION: Final = ("u", "v", "r", "p", "phi", "psi", "U", "beta", "Fn")
CONTROLS: Final = ("delta", "n", "n_order", "bucket")
PARTICULARS: Final = ("L", "B", "d", "mass", "volume", "GM", "rho", "g")
CONDITIONS: Final = ("wind_speed", "wind_direction", "depth", "wave_height", "wave_direction")
GIVEN: Final = frozenset((*MOTION, *CONTROLS, *PARTICULARS, *CONDITIONS))
"""Names that an effect finds without any other effect."""
ENGINE: Final = ("equilibrium.py", "integrator.py", "queries.py")
SAILING: Final = (*ENGINE, "lanes.py")
"""What sails many ships at once."""
CARRYING: Final = ("equilibrium.py", "integrator.py", "communication.py", "surroundings.py")
"""What a program in another language is made of; with it stands `forces`."""
ESTIMATING: Final = ("equilibrium.py", "integrator.py", "sensors.py", "intervals.py", FILTERS)
"""What carries records through filters; the filters themselves know nothing of ships."""
OF_ARRAYS: Final = ("sensors.py", "intervals.py", FILTERS)
"""What takes arrays of several dimensions: numba compiles it."""
ENTRIES: Final = (
    "rates",
    "complete",
    "self_propulsion",
    "run",
    "probe",
    "sample",
    "run_many",
    "settle",
    "repeat",
    "constants",
    "advance",
    "linearised",
    "correct",
    "predict",
    "wander",
    "scatter",
    "extended",
    "smoothed",
    "unscented",
    "windows",
    "pushed",
    "along",
    "tangents",
    "shown",
    "steered",
)
"""Functions that are called from outside the module."""
LANES: Final = 8
"""Ships side by side: a vector of AVX-512, two of AVX2. It enters no result."""
_NUMBER: Final = re.compile(r"^[A-Z][A-Z_, ]* = .*$", re.MULTILINE)
_HEAD: Final = re.compile(r"^def (\w+)\((.*)\):$", re.MULTILINE)
_OF_LANES: Final = ("sin", "cos", "atan2")
_FACTORS: Final = {
    "u": "surge",
    "v": "sway",
    "r": "yaw",
    "p": "roll",
    "phi": "phi",
    "d": "delta",
    "|u|": "fabs(surge)",
    "|v|": "fabs(sway)",
    "|r|": "fabs(yaw)",
    "|p|": "fabs(roll)",
    "|d|": "fabs(delta)",
}


def module_text(structure: EquationStructure, files: tuple[str, ...] = ENGINE) -> str:
    """Python text of the equations of a structure, followed by the engine."""
    return "\n".join((*module_parts(structure, files), ""))


@cache
def module_parts(structure: EquationStructure, files: tuple[str, ...]) -> tuple[str, str]:
    """The text of a module in two parts: that of functions of lists, and that of arrays."""
    lines = ["import math", "from math import atan2, cos, fabs, sin, sqrt"]
    for item in structure.used:
        lines += [*_taken_in(item), f"effect_{item.effect} = plain_{item.effect}"]
    free, balance = _balanced(structure)
    states = structure.states
    lines += [
        f"NS = {len(states)}",
        f"OWN = {len(states) - len(structure.brought)}",
        f"N_AT = {states.index('n') if 'n' in states else -1}",
        f"REVOLUTIONS = {int(structure.revolutions)}",
        f"FREE = {free}",
        f"BALANCE = {balance}",
        f"STRIDE = {len(StepField) + 5 * len(states)}",
        "TWICE = 2.0 * math.pi",
        "",
        *_rates(structure, heeled=structure.rolls or files == ESTIMATING),
        *(_forces(structure) if files == CARRYING else []),
        *(_rates_of_lanes(structure) if files == SAILING else []),
        "",
        _functions(tuple(name for name in files if name not in OF_ARRAYS)),
    ]
    return "\n".join(lines), _functions(tuple(name for name in files if name in OF_ARRAYS))


def entries_text(text: str, arrays: str) -> str:
    """What numba compiles of the parts of a module: numbers, entries, functions that take arrays.

    Entries hand over to the functions of lists as `pmmkit.equations.machine_code.written`.
    """
    lines = ["import math", "", *_NUMBER.findall(text), ""]
    for name, given in _HEAD.findall(text):
        if name in ENTRIES:
            lines += [
                f"written_{name} = written({name!r})",
                "@entry",
                f"def {name}({given}):",
                f"    return written_{name}(({given},))",
                "",
            ]
    return "\n".join([*lines, arrays])


def _taken_in(item: Used) -> list[str]:
    """The plain function of an effect: imported, or written out where a user's text makes it."""
    name = f"plain_{item.effect}"
    if item.text:
        words = ", ".join(PRIMITIVES)
        own = replace(function_of_text(item.effect, item.text), name=name)
        return [f"from {rebound.__module__} import {words}", *python_lines(own), ""]
    return [
        f"from {catalogue.__module__} import catalogue",
        f"{name} = catalogue()[{item.effect!r}].force",
    ]


def _balanced(structure: EquationStructure) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """States of a steady turn, and the rates that vanish in it."""
    extra = [i for i, name in enumerate(structure.states) if name not in (*STATES, *ROLLING)]
    moving: list[int] = [State.u, State.v, State.r]
    free = [*moving, State.phi] if structure.rolls else moving
    balance = [*moving, State.p] if structure.rolls else moving
    return tuple(map(int, [*free, *extra])), tuple(map(int, [*balance, *extra]))


def _instant(structure: EquationStructure, *, heeled: bool) -> list[str]:
    """Names of the states and of the controls."""
    states = structure.states
    own = structure.brought
    body = [f"u, v, r, psi = y[{State.u}], y[{State.v}], y[{State.r}], y[{State.psi}]"]
    if structure.rolls:
        body.append(f"p, phi = y[{State.p}], y[{State.phi}]")
    elif heeled:
        body.append(f"p, phi = k[{Constant.roll_rate}], k[{Constant.roll}]")
    else:
        body.append("p, phi = 0.0, 0.0")
    body += [f"{name} = y[{states.index(name)}]" for name in own if name != "n"]
    body.append(f"n = y[{states.index('n')}]" if "n" in own else "n = revolutions")
    return [*body, "n_order = revolutions", "U = max(sqrt(u * u + v * v), 1e-9)"]


def _rates(structure: EquationStructure, *, heeled: bool) -> list[str]:
    """The equations; of a ship without roll `heeled` takes the heel from the constants."""
    return [
        "def rates(y, delta, revolutions, bucket, k, out):",
        *(f"    {line}" for line in _equations(structure, heeled=heeled)),
    ]


def _equations(structure: EquationStructure, *, heeled: bool) -> list[str]:
    """Lines from `y`, the controls and `k` to `out`."""
    body = _instant(structure, heeled=heeled)
    lines, extra_mass, rates_of = summed(structure)
    lines += _motion(structure, extra_mass, heeled=heeled)
    body += _at_the_moment(structure, lines) if structure.follows else lines
    return body + [
        f"out[{structure.states.index(name)}] = {rates_of[name]}" for name in structure.brought
    ]


def _rewritten(lines: Sequence[str], rule: Callable[[Expression], Expression]) -> list[str]:
    """Lines in which each part of the syntax is what a rule makes of it."""
    return python_lines([item.replaced(rule) for item in statements("\n".join(lines))])


def _rates_of_lanes(structure: EquationStructure) -> list[str]:
    """The same equations for all lanes: what lies side by side in `y`, `k` and `out` lies so too.

    A loop of an effect, or a search in a table, is not made vectors of: such a ship has all lanes
    for itself, which is one, and the functions of the C library.
    """
    lanes, size = LANES if _straight(structure) else 1, len(structure.states)
    times = len(LaneSlot) * size * lanes
    moves = times + lanes
    begin = {
        "y": LaneSlot.z * size * lanes,
        "out": LaneSlot.rate * size * lanes,
        "k": moves + len(Control) * len(LaneMove) * lanes,
    }
    controls = [moves + (len(LaneMove) * c + LaneMove.value) * lanes for c in Control]
    head = ["", f"LANES, TIMES, MOVES, WIDE = {lanes}, {times}, {moves}, {begin['k']}"]
    if lanes == 1:
        y, out = (f"part(s, {begin[name]}, {size})" for name in ("y", "out"))
        k = f"part(s, {begin['k']}, len(s) - {begin['k']})"
        return [
            *head,
            "exponential = math.exp",
            "",
            "def rates_of_lanes(s):",
            f"    rates({y}, {', '.join(f's[{at}]' for at in controls)}, {k}, {out})",
        ]

    lines = _rewritten(_equations(structure, heeled=structure.rolls), _in_lanes(begin, lanes))
    return [
        *head,
        "exponential = lane_functions.exp",
        *(f"lane_{name} = lane_functions.{name}" for name in _OF_LANES),
        *(f"lane_{x.effect} = in_lanes(plain_{x.effect})" for x in structure.used),
        "",
        "def rates_of_lanes(s):",
        f"    for lane in range({lanes}):",
        f"        delta, revolutions, bucket = {', '.join(f's[{at} + lane]' for at in controls)}",
        *(f"        {line}" for line in lines),
    ]


def _in_lanes(begin: Mapping[str, int], lanes: int) -> Callable[[Expression], Expression]:
    """What stands for lists, and for functions that have others for lanes, in a loop over lanes."""

    def rule(node: Expression) -> Expression:
        match node:
            case Subscript(of=Name(word=word), at=Number(value=at)) if word in begin:
                first = Number(begin[word] + lanes * int(at))
                return Subscript(Name("s"), Binary("+", first, Name("lane")))
            case Subscript(
                of=Name(word=word), at=Span(low=Number(value=low), high=Number(value=high))
            ) if word in begin:
                ends = (Number(begin[word] + lanes * int(at)) for at in (low, high))
                return Subscript(Name("s"), Span(*ends))
            case Call(function=Name(word=word)) if word in _OF_LANES or word.startswith("effect_"):
                return replace(node, function=Name(f"lane_{word.removeprefix('effect_')}"))
        return node

    return rule


def _straight(structure: EquationStructure) -> bool:
    """Whether the equations are free of loops and of searches in tables."""
    return (
        structure.products is not None
        and not structure.follows
        and all(length == 1 for item in structure.used for _, length in item.tables)
        and not any(_loops(item.known.force) for item in structure.used)
    )


def _loops(function: Any) -> bool:
    """Whether a function of an effect, or one that it calls, holds a loop."""
    code = function.__code__
    if any("FOR_ITER" in x.opname or "BACKWARD" in x.opname for x in dis.get_instructions(code)):
        return True
    called = (function.__globals__.get(name) for name in code.co_names)
    return any(
        _loops(other)
        for other in called
        if isinstance(other, FunctionType) and other.__module__ != rebound.__module__
    )


def _forces(structure: EquationStructure) -> list[str]:
    """A function that fills `out` with `told`: what the water and the air do to the ship."""
    lines, _, _ = summed(structure)
    body = _instant(structure, heeled=structure.rolls)
    body += _at_the_moment(structure, lines) if structure.follows else lines
    body += [f"out[{place}] = {name}" for place, name in enumerate(structure.told)]
    return [
        "",
        "def forces(y, delta, revolutions, bucket, k, out):",
        *(f"    {line}" for line in body),
    ]


def _at_the_moment(structure: EquationStructure, lines: Sequence[str]) -> list[str]:
    """Lines with the constants that follow the speed in place of those of the approach.

    Between two speeds they lie on a line, as `Model.values` has them; beyond the first and the
    last they are held.
    """
    begin, width = structure.width + 1, 1 + len(structure.follows)
    following = [
        f"here, last = {begin}, {begin} + {width} * (int(k[{structure.width}]) - 2)",
        f"while here < last and U > k[here + {width}]:",
        f"    here += {width}",
        f"share = (U - k[here]) / (k[here + {width}] - k[here])",
        "share = min(max(share, 0.0), 1.0)",
        "rest = 1.0 - share",
        *(
            f"k_{place} = rest * k[here + {i}] + share * k[here + {width + i}]"
            for i, place in enumerate(structure.follows, start=1)
        ),
    ]

    def own(node: Expression) -> Expression:
        match node:
            case Subscript(of=Name(word="k"), at=Number(value=place)) if place in structure.follows:
                return Name(f"k_{place}")
        return node

    return following + _rewritten(lines, own)


def summed(structure: EquationStructure) -> tuple[list[str], dict[str, list[str]], dict[str, str]]:
    """Lines that sum the forces of all effects into X, Y, N, K; with what they leave."""
    body = [f"{name} = k[{Constant[name]}]" for name in (*PARTICULARS, *CONDITIONS)]
    if any("beta" in item.arguments for item in structure.used):
        body.append("beta = atan2(-v, u)")
    if any("Fn" in item.arguments for item in structure.used):
        body.append("Fn = U / sqrt(g * L)")
    body.append("X, Y, N, K = " + ", ".join(f"k[{Constant[f'more_{x}']}]" for x in CHANNELS))
    body += _polynomial(structure)
    places = structure.places()
    extra_mass: dict[str, list[str]] = {}
    rates_of: dict[str, str] = {}
    for item in structure.used:
        call, taken = _call(item, places)
        body.append(call)
        for output, variable in taken:
            if output in CHANNELS:
                body.append(f"{output} += {variable}")
            elif output in ACCELERATIONS:
                extra_mass.setdefault(output, []).append(variable)
            elif output.endswith("_rate") and output[:-5] in structure.brought:
                rates_of[output[:-5]] = variable
            else:
                body.append(f"{output} = {variable}")
    return body, extra_mass, rates_of


def _polynomial(structure: EquationStructure) -> list[str]:
    lines = [
        f"reference = k[{Constant.reference}] if k[{Constant.reference}] > 0.0 else U",
        f"square = k[{Constant.square}] if k[{Constant.square}] > 0.0 else reference * reference",
        "inverse = 1.0 / reference",
        f"surge, sway = (u - k[{Constant.loss_from}]) * inverse, v * inverse",
        "yaw, roll = r * L * inverse, p * L * inverse",
    ]
    if structure.products is None:
        factors = ", ".join("1.0" if f == "0" else _FACTORS[f] for f in FACTOR_PLACES)
        return [
            *lines,
            f"factors = ({factors})",
            f"at = {structure.width}",
            "for _ in range(int(k[at])):",
            "    product = square",
            "    for _ in range(int(k[at + 1])):",
            "        at += 1",
            "        product *= factors[int(k[at + 1])]",
            "    X += k[at + 2] * product",
            "    Y += k[at + 3] * product",
            "    N += k[at + 4] * product",
            "    K += k[at + 5] * product",
            "    at += 5",
        ]
    known: dict[tuple[int, ...], str] = {(): "square"}
    sums: dict[str, list[str]] = {channel: [] for channel in CHANNELS}
    place = len(Constant)
    for factors_of, channels in structure.products:
        for length in range(1, len(factors_of) + 1):
            prefix = factors_of[:length]
            if prefix not in known:
                known[prefix] = "_".join(["t", *map(str, prefix)])
                factor = _FACTORS[FACTOR_PLACES[prefix[-1]]]
                lines.append(f"{known[prefix]} = {known[prefix[:-1]]} * {factor}")
        for channel in channels:
            sums[channel].append(f"k[{place}] * {known[factors_of]}")
            place += 1
    lines += [f"{channel} += {' + '.join(terms)}" for channel, terms in sums.items() if terms]
    return lines


def _call(item: Used, places: dict[tuple[str, str], slice]) -> tuple[str, list[tuple[str, str]]]:
    options, tables = dict(item.options), dict(item.tables)
    words = []
    for name in item.arguments:
        if name in item.own:
            at = places[item.effect, name]
            words.append(f"k[{at.start}:{at.stop}]" if name in tables else f"k[{at.start}]")
        elif name in options:
            words.append(str(options[name]))
        else:
            words.append(name)
    taken = [(output, f"{item.effect}_{output}") for output in item.known.outputs]
    left = ", ".join(variable for _, variable in taken) + ("," if len(taken) == 1 else "")
    return f"{left} = effect_{item.effect}({', '.join(words)})", taken


def _motion(
    structure: EquationStructure, extra: dict[str, list[str]], *, heeled: bool
) -> list[str]:
    lines = [
        f"mass_xG = mass * k[{Constant.xG}]",
        f"X += (mass + k[{Constant.coriolis_x}]) * v * r + mass_xG * r * r",
        f"Y += (k[{Constant.coriolis_y}] - mass) * u * r",
        "N -= mass_xG * u * r",
        "ahead, aside = cos(psi), sin(psi)",
    ]
    if structure.rolls:
        lines.append(f"K += (k[{Constant.coriolis_k}] + mass * k[{Constant.zG}]) * u * r")
    if heeled:
        lines += ["upright = cos(phi)", "level = v * upright"]
    if heeled and not structure.rolls:
        gain = f"k[{Constant.roll_acceleration}]"
        lines += [
            f"Y += (mass * k[{Constant.zG}] + k[{Constant.Ypdot}]) * {gain}",
            f"N += k[{Constant.Npdot}] * {gain}",
        ]
    across = "level" if heeled else "v"
    lines += [
        f"out[{State.x}] = u * ahead - {across} * aside + k[{Constant.current_x}]",
        f"out[{State.y}] = u * aside + {across} * ahead + k[{Constant.current_y}]",
        f"out[{State.psi}] = r * upright" if heeled else f"out[{State.psi}] = r",
    ]
    if extra or any(Constant[name] in structure.follows for name in ACCELERATIONS):
        lines += _extra_mass(structure, extra)
    else:
        lines.append(f"out[{State.u}] = X / k[{Constant.surge_mass}]")
        turning = {"Y": State.v, "N": State.r} | ({"K": State.p} if structure.rolls else {})
        for row, state in enumerate(turning.values(), start=1):
            shares = [f"k[{Constant[f'i{row}{i}']}] * {x}" for i, x in enumerate(turning, start=1)]
            lines.append(f"out[{state}] = {' + '.join(shares)}")
    return [*lines, f"out[{State.phi}] = p"] if structure.rolls else lines


def _extra_mass(structure: EquationStructure, extra: dict[str, list[str]]) -> list[str]:
    """The mass matrix with shares that depend on the motion, solved at each instant."""

    def entry(constant: str, derivative: str) -> str:
        more = "".join(f" - {variable}" for variable in extra.get(derivative, ()))
        return f"{constant} - k[{Constant[derivative]}]{more}"

    matrix = {
        (1, 1): ("mass", "Yvdot"),
        (1, 2): ("mass_xG", "Yrdot"),
        (1, 3): (f"-mass * k[{Constant.zG}]", "Ypdot"),
        (2, 1): ("mass_xG", "Nvdot"),
        (2, 2): (f"k[{Constant.Izz}]", "Nrdot"),
        (2, 3): ("0.0", "Npdot"),
        (3, 1): (f"-mass * k[{Constant.zG}]", "Kvdot"),
        (3, 2): ("0.0", "Krdot"),
        (3, 3): (f"k[{Constant.Ixx}]", "Kpdot"),
    }
    lines = [f"out[{State.u}] = X / ({entry('mass', 'Xudot')})"]
    for (i, j), (constant, derivative) in matrix.items():
        if structure.rolls or (i < 3 and j < 3):
            lines.append(f"a{i}{j} = {entry(constant, derivative)}")
    if not structure.rolls:
        return [
            *lines,
            "det = a11 * a22 - a12 * a21",
            *_refused(structure, "a11", "a22"),
            f"out[{State.v}] = (a22 * Y - a12 * N) / det",
            f"out[{State.r}] = (a11 * N - a21 * Y) / det",
        ]
    return [
        *lines,
        "c11, c12, c13 = a22*a33 - a23*a32, a13*a32 - a12*a33, a12*a23 - a13*a22",
        "det = a11 * c11 + a21 * c12 + a31 * c13",
        *_refused(structure, "a11", "a22", "a33"),
        f"out[{State.v}] = (c11 * Y + c12 * N + c13 * K) / det",
        f"out[{State.r}] = ("
        "(a23*a31 - a21*a33) * Y + (a11*a33 - a13*a31) * N + (a13*a21 - a11*a23) * K) / det",
        f"out[{State.p}] = ("
        "(a21*a32 - a22*a31) * Y + (a12*a31 - a11*a32) * N + (a11*a22 - a12*a21) * K) / det",
    ]


def _refused(structure: EquationStructure, *diagonal: str) -> list[str]:
    """No motion goes on where a mass matrix that follows the speed is not positive.

    Of one that does not, `complete` looks at all there is.
    """
    positive = " and ".join(f"{entry} > 0.0" for entry in (*diagonal, "det"))
    return [f"det = det if {positive} else math.nan"] if structure.follows else []


_LAYOUTS: Final = {
    name: layout
    for name, layout in vars(layouts).items()
    if isinstance(layout, EnumType) and layout is not IntEnum
}


def _numbers(node: Expression) -> Expression:
    """Numbers of members and lengths of layouts for their names; what adds nothing is left out."""
    match node:
        case Member(of=Name(word=layout), word=member) if layout in _LAYOUTS:
            return Number(int(_LAYOUTS[layout][member]))
        case Call(function=Name(word="len"), inner=(Name(word=layout),)) if layout in _LAYOUTS:
            return Number(len(_LAYOUTS[layout]))
        case Binary(sign="+", left=term, right=Number(value=int(0))):
            return term
    return node


@cache
def _functions(files: tuple[str, ...]) -> str:
    """The functions of files, decorated, the names of layouts written out as numbers."""
    parts = []
    for name in files:
        text = Path(__file__).parent.joinpath(name).read_text(encoding="utf-8")
        for own in functions(text).values():
            mark = "entry" if own.name in ENTRIES else "inner"
            own = own.replaced(_numbers)
            parts += [*python_lines(own, mark=mark if name in OF_ARRAYS else ""), ""]
    return "\n".join(parts)
