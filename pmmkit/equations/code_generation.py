"""The text of a module with the equations of one structure and the engine that integrates them."""

from __future__ import annotations

import ast
from functools import cache
from pathlib import Path
from typing import Final

from pmmkit.effects import primitives
from pmmkit.effects.catalogue import effect_of
from pmmkit.effects.grammar import source_of
from pmmkit.effects.hull import FACTOR_PLACES
from pmmkit.equations.constants import FIRST, PLACE, STATES
from pmmkit.equations.structure import ACCELERATIONS, FORCES, Structure, Used

MOTION: Final = ("u", "v", "r", "p", "phi", "psi", "U", "beta", "Fn")
CONTROLS: Final = ("delta", "n", "n_order", "bucket")
PARTICULARS: Final = ("L", "B", "d", "mass", "volume", "GM", "rho", "g")
CONDITIONS: Final = ("wind_speed", "wind_direction", "depth")
GIVEN: Final = frozenset((*MOTION, *CONTROLS, *PARTICULARS, *CONDITIONS))
"""Names that an effect finds without any other effect."""
ENGINE: Final = ("integrator.py", "queries.py")
ESTIMATING: Final = ("integrator.py", "estimators.py")
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
    "extended",
    "smoothed",
    "unscented",
    "windows",
    "along",
    "take_in",
)
"""Functions that are called from outside the module."""
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


def module_text(structure: Structure, files: tuple[str, ...] = ENGINE) -> str:
    """Python text of the equations of a structure, followed by the engine.

    Parameters
    ----------
    structure : Structure
        Validated: its names come from the catalogue, never from a file's text.
    files : tuple of str
        Files of this package whose functions follow the equations.

    Returns
    -------
    str
        A module in which ``entry`` and ``inner`` decorate the functions and ``use`` takes in those
        of the effects; the loader supplies all three.
    """
    lines = ["import math", "from math import atan2, cos, fabs, sin, sqrt"]
    for item in structure.used:
        lines += [*_taken_in(item), f"effect_{item.effect} = use(plain_{item.effect})"]
    free, balance = _balanced(structure)
    states = structure.states
    lines += [
        f"NS = {len(states)}",
        f"N_AT = {states.index('n') if 'n' in states else -1}",
        f"TURNS = {int(structure.turns)}",
        f"FREE = {free}",
        f"BALANCE = {balance}",
        "STRIDE = 2 + 5 * NS",
        "TWICE = 2.0 * math.pi",
        "",
        *_rates(structure),
        "",
        _functions(files),
    ]
    return "\n".join(lines) + "\n"


def _taken_in(item: Used) -> list[str]:
    """The plain function of an effect: imported, or written out where a user's text makes it."""
    name = f"plain_{item.effect}"
    if item.text:
        words = ", ".join(primitives.__all__)
        source = source_of(item.effect, item.text).replace("def force(", f"def {name}(", 1)
        return [f"from {primitives.__name__} import {words}", source]
    return [
        f"from {effect_of.__module__} import effect_of",
        f"{name} = effect_of({item.effect!r}).force",
    ]


def _balanced(structure: Structure) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """States of a steady turn, and the rates that vanish in it."""
    extra = tuple(i for i, name in enumerate(structure.states) if name not in (*STATES, "p", "phi"))
    if structure.rolls:
        return (3, 4, 5, 7, *extra), (3, 4, 5, 6, *extra)
    return (3, 4, 5, *extra), (3, 4, 5, *extra)


def _rates(structure: Structure) -> list[str]:
    states = structure.states
    own = structure.brought
    body = ["u, v, r, psi = y[3], y[4], y[5], y[2]"]
    body += ["p, phi = y[6], y[7]"] if structure.rolls else ["p, phi = 0.0, 0.0"]
    body += [f"{name} = y[{states.index(name)}]" for name in own if name != "n"]
    body.append(f"n = y[{states.index('n')}]" if "n" in own else "n = turn")
    body += ["n_order = turn", "U = max(sqrt(u * u + v * v), 1e-9)"]
    lines, extra_mass, rates_of = summed(structure)
    body += [*lines, *_motion(structure, extra_mass)]
    body += [f"out[{states.index(name)}] = {rates_of[name]}" for name in own]
    return [
        "@entry",
        "def rates(y, delta, turn, bucket, k, out):",
        *(f"    {line}" for line in body),
    ]


def summed(structure: Structure) -> tuple[list[str], dict[str, list[str]], dict[str, str]]:
    """Lines that sum the forces of all effects into X, Y, N, K; with what they leave.

    Returns
    -------
    list of str
        The lines; motion, controls and U must be there.
    dict of str to list of str
        Variables with shares of the mass matrix, by acceleration derivative.
    dict of str to str
        Variables with the rates of the states that effects bring.
    """
    body = [f"{name} = k[{PLACE[name]}]" for name in (*PARTICULARS, *CONDITIONS)]
    if any("beta" in item.arguments for item in structure.used):
        body.append("beta = atan2(-v, u)")
    if any("Fn" in item.arguments for item in structure.used):
        body.append("Fn = U / sqrt(g * L)")
    body.append("X, Y, N, K = " + ", ".join(f"k[{PLACE[f'more_{x}']}]" for x in FORCES))
    body += _polynomial(structure)
    places = structure.places()
    extra_mass: dict[str, list[str]] = {}
    rates_of: dict[str, str] = {}
    for item in structure.used:
        call, taken = _call(item, places)
        body.append(call)
        for output, variable in taken:
            if output in FORCES:
                body.append(f"{output} += {variable}")
            elif output in ACCELERATIONS:
                extra_mass.setdefault(output, []).append(variable)
            elif output.endswith("_rate") and output[:-5] in structure.brought:
                rates_of[output[:-5]] = variable
            else:
                body.append(f"{output} = {variable}")
    return body, extra_mass, rates_of


def _polynomial(structure: Structure) -> list[str]:
    lines = [
        "reference = k[36] if k[36] > 0.0 else U",
        "square = k[37] if k[37] > 0.0 else reference * reference",
        "inverse = 1.0 / reference",
        "surge, sway = (u - k[38]) * inverse, v * inverse",
        "yaw, roll = r * L * inverse, p * L * inverse",
    ]
    if structure.products is None:
        factors = ", ".join("1.0" if f == "0" else _FACTORS[f] for f in FACTOR_PLACES)
        return [
            *lines,
            f"factors = ({factors})",
            "at = int(k[-1])",
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
    sums: dict[str, list[str]] = {channel: [] for channel in FORCES}
    place = FIRST
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


def _motion(structure: Structure, extra: dict[str, list[str]]) -> list[str]:
    lines = [
        "mass_xG = mass * k[8]",
        "X += (mass + k[23]) * v * r + mass_xG * r * r",
        "Y += (k[24] - mass) * u * r",
        "N -= mass_xG * u * r",
        "ahead, aside = cos(psi), sin(psi)",
    ]
    if structure.rolls:
        lines += ["K += (k[25] + mass * k[9]) * u * r", "upright = cos(phi)", "level = v * upright"]
    across = "level" if structure.rolls else "v"
    lines += [
        f"out[0] = u * ahead - {across} * aside + k[42]",
        f"out[1] = u * aside + {across} * ahead + k[43]",
        "out[2] = r * upright" if structure.rolls else "out[2] = r",
    ]
    if extra:
        lines += _extra_mass(structure, extra)
    elif structure.rolls:
        lines += [
            "out[3] = X / k[26]",
            "out[4] = k[27] * Y + k[28] * N + k[29] * K",
            "out[5] = k[30] * Y + k[31] * N + k[32] * K",
            "out[6] = k[33] * Y + k[34] * N + k[35] * K",
        ]
    else:
        lines += [
            "out[3] = X / k[26]",
            "out[4] = k[27] * Y + k[28] * N",
            "out[5] = k[30] * Y + k[31] * N",
        ]
    return [*lines, "out[7] = p"] if structure.rolls else lines


def _extra_mass(structure: Structure, extra: dict[str, list[str]]) -> list[str]:
    """The mass matrix with shares that depend on the motion, solved at each instant."""

    def entry(constant: str, derivative: str) -> str:
        more = "".join(f" - {variable}" for variable in extra.get(derivative, ()))
        return f"{constant} - k[{PLACE[derivative]}]{more}"

    matrix = {
        (1, 1): ("mass", "Yvdot"),
        (1, 2): ("mass_xG", "Yrdot"),
        (1, 3): ("-mass * k[9]", "Ypdot"),
        (2, 1): ("mass_xG", "Nvdot"),
        (2, 2): ("k[10]", "Nrdot"),
        (2, 3): ("0.0", "Npdot"),
        (3, 1): ("-mass * k[9]", "Kvdot"),
        (3, 2): ("0.0", "Krdot"),
        (3, 3): ("k[11]", "Kpdot"),
    }
    lines = [f"out[3] = X / ({entry('mass', 'Xudot')})"]
    for (i, j), (constant, derivative) in matrix.items():
        if structure.rolls or (i < 3 and j < 3):
            lines.append(f"a{i}{j} = {entry(constant, derivative)}")
    if not structure.rolls:
        return [
            *lines,
            "det = a11 * a22 - a12 * a21",
            "out[4] = (a22 * Y - a12 * N) / det",
            "out[5] = (a11 * N - a21 * Y) / det",
        ]
    return [
        *lines,
        "c11, c12, c13 = a22*a33 - a23*a32, a13*a32 - a12*a33, a12*a23 - a13*a22",
        "det = a11 * c11 + a21 * c12 + a31 * c13",
        "out[4] = (c11 * Y + c12 * N + c13 * K) / det",
        "out[5] = ((a23*a31 - a21*a33) * Y + (a11*a33 - a13*a31) * N + (a13*a21 - a11*a23) * K)"
        " / det",
        "out[6] = ((a21*a32 - a22*a31) * Y + (a12*a31 - a11*a32) * N + (a11*a22 - a12*a21) * K)"
        " / det",
    ]


@cache
def _functions(files: tuple[str, ...]) -> str:
    """The functions of files, decorated."""
    nodes = [
        node
        for name in files
        for node in ast.parse(Path(__file__).with_name(name).read_text(encoding="utf-8")).body
        if not (isinstance(node, ast.FunctionDef) and _stands_for_another(node))
    ]
    parts = []
    for node in nodes:
        if isinstance(node, ast.FunctionDef):
            for argument in node.args.args:
                argument.annotation = None
            node.returns = None
            node.body = node.body[1:] if ast.get_docstring(node) else node.body
            mark = "@entry" if node.name in ENTRIES else "@inner"
            if node.name != "vector":
                parts.append(f"{mark}\n{ast.unparse(node)}\n")
    return "\n".join(parts)


def _stands_for_another(node: ast.FunctionDef) -> bool:
    """Whether a function does nothing but raise, so that another of its name takes its place."""
    return isinstance(node.body[-1], ast.Raise)
