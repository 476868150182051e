"""A model as a function file for MATLAB and Octave, in the style of the MSS toolbox."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

from pmmkit.base import ModelError, Problem
from pmmkit.conventions import CHANNELS
from pmmkit.effects import CATALOGUE, INERTIA, function_of_text
from pmmkit.equations import ACCELERATIONS, POLYNOMIALS, Prepared, Used, prepare
from pmmkit.exports.matlab.hull import hull_lines, mass_lines, motion_lines, variable
from pmmkit.exports.text import WHICH_SPEED, written_by
from pmmkit.models import Model, model_text
from pmmkit.syntax import (
    Binary,
    MatlabLine,
    Name,
    Unwritable,
    comment,
    is_matlab_name,
    matlab_name,
    matlab_value,
    transcribe,
)

# What the function of a model says of itself: the comment that MATLAB shows as its help.


_STATES: Final = {
    "u": ("surge velocity", "m/s"),
    "v": ("sway velocity", "m/s"),
    "r": ("yaw velocity", "rad/s"),
    "x": ("position in x-direction", "m"),
    "y": ("position in y-direction", "m"),
    "psi": ("yaw angle", "rad"),
    "p": ("roll velocity", "rad/s"),
    "phi": ("roll angle", "rad"),
    "delta": ("actual rudder angle", "rad"),
    "n": ("actual shaft velocity", "rpm"),
}


def meaning(model: Model) -> str:
    """What the derivatives of a model are, in words."""
    convention = model.convention
    unit = {
        "prime": "forces over rho/2 L^2 U^2, moments over rho/2 L^3 U^2",
        "prime-d": "forces over rho/2 L d U^2, moments over rho/2 L^2 d U^2",
        "bis": "forces over rho g volume, moments over rho g volume L, speeds over sqrt(g L)",
    }[convention.system]
    coriolis = {
        "separate": "Coriolis terms of the added mass in the equations of motion",
        "in-derivatives": "Coriolis terms of the added mass inside the derivatives",
    }[convention.coriolis]
    return f"derivatives in the {convention.system} system ({unit}), {coriolis}"


def heading(
    model: Model,
    called: str,
    states: Sequence[str],
    inputs: Sequence[str],
    *,
    speed: float | None,
    revolutions: float | None,
    about: bool,
) -> list[str]:
    """The comment behind the first line: states, inputs, axes, sources, the program.

    speed [m/s]; revolutions [1/s].
    """
    listed = " ".join(states)
    lines = comment(
        f"[xdot,U] = {called} returns the speed U in m/s (optionally) and the time derivative of "
        f"the state vector x = [ {listed} ]' for {model.title or model.name}, "
        f"L = {model.ship.L:g} m."
    )
    lines.append("%")
    for name in states:
        text, unit = _STATES[name]
        if name == "u" and about:
            text = "perturbed surge velocity about U0"
        lines += comment(f"{name:<5} = {text} ({unit})")
    lines += ["%", *comment(f"Input: ui = [ {' '.join(inputs)} ]'"), "%"]
    lines += comment("delta_c = commanded rudder angle (rad)")
    if "n_c" in inputs:
        follows = "" if "n" in states else ", which the shaft has at once"
        lines += comment(f"n_c = commanded shaft velocity (rpm){follows}")
        if revolutions is not None:
            lines += comment(
                f"Without n_c: {60 * revolutions:.6g} rpm, self-propulsion at {speed:g} m/s."
            )
    if ",U0)" in called:
        lines += comment(f"U0 = nominal speed (m/s), {speed:g} m/s if left out")
    lines += [
        "%",
        *comment(
            "Axes: x forward, y to starboard, z down, origin midship. A positive rudder angle "
            "(delta and delta_c) turns the ship to starboard. Calm water, no current."
        ),
    ]
    if model.Fn:
        assert speed is not None
        froude = model.ship.froude(speed, model.water.g)
        ends = ", ".join(f"{x:.4g}" for x in model.Fn)
        lines += comment(f"Values at Fn {froude:.4g} ({speed:g} m/s), from those at Fn {ends}.")
    lines += comment(f"Scale: {model.scale}") if model.scale else []
    for note in model.notes:
        lines += comment(f"Note: {note}")
    digest = hashlib.sha256(model_text(model).encode()).hexdigest()
    lines += ["%", *written_by()]
    lines += comment(f"Model: {model.name}; SHA-256 of its file as pmmkit writes it: {digest}")
    for step in model.history:
        lines += comment(f"Step: {step}")
    return lines


_WIDTH: Final = 80
_ANY_FROUDE: Final = 0.2
"""Where a model has one set of values for all speeds, any speed gives its structure."""
_NO_INPUT: Final = {
    "wind_speed": "the wind",
    "wind_direction": "the wind",
    "bucket": "the bucket of a waterjet",
}
_PARTICULARS: Final = {
    "L": "length between perpendiculars (m)",
    "B": "breadth (m)",
    "d": "draught (m)",
    "volume": "displaced volume (m3)",
    "mass": "mass (kg)",
    "xG": "centre of gravity forward of midship (m)",
    "zG": "centre of gravity below the origin (m)",
    "GM": "metacentric height (m)",
    "Izz": "yaw inertia about midship (kg m2)",
    "Ixx": "roll inertia (kg m2)",
}
_BREAKS: Final = re.compile(r"(?= [-+] )|(?<=, )|(?=\*\(|\*sqrt\()")
_HELPERS: Final = {
    "where": """\
function y = where(condition, yes, no)
% One of two numbers.
if condition, y = yes; else, y = no; end
end""",
    "interpolate": """\
function y = interpolate(x, xs, ys)
% Straight lines through points with ascending xs, constant beyond both ends.
y = interp1(xs, ys, max(min(x, xs(end)), xs(1)));
end""",
    "interpolate_rows": """\
function z = interpolate_rows(x, xs, y, ys, rows)
% Straight lines both ways in a table, a row over ys for each of xs, constant beyond its edges.
x = max(min(x, xs(end)), xs(1));
y = max(min(y, ys(end)), ys(1));
z = interp2(ys, xs, reshape(rows, numel(ys), numel(xs)).', y, x);
end""",
}


_Section = tuple[str, Sequence[MatlabLine]]
"""A heading, and the lines below it."""


def model_to_mss(model: Model, *, name: str | None = None, speed: float | None = None) -> str:
    """The text of a function ``[xdot,U] = name(x,ui)`` with the equations of motion of a model.

    speed [m/s].

    Notes
    -----
    x = [u v r x y psi delta]', with p and phi before delta where the ship rolls and n behind it
    where the shaft has dynamics; ui = [delta_c n]', without n where no propeller is modelled. As in
    ``mariner.m`` of Fossen's Marine Systems Simulator u is the loss of speed from U0 where the
    derivatives are written in it, as in ``container.m`` the surge velocity otherwise. The rudder
    follows with a time constant of 1 s at most at its rate, as in both.

    Examples
    --------
    >>> from pmmkit.models import load_model
    >>> print(model_to_mss(load_model("kvlcc2-l7")).splitlines()[0])
    function [xdot,U] = kvlcc2_l7(x,ui)
    """
    function = matlab_name(model.name) if name is None else name
    if not is_matlab_name(function):
        raise ModelError(
            f"{function!r} is no name of a function in MATLAB. Choose a file name of letters, "
            f"digits and underscores that starts with a letter."
        )
    about = model.convention.surge == "delta-u"
    approach = about or (model.convention.U == "carriage" and model.convention.system != "bis")
    _check_speed(model, speed, approach=approach)
    at = model.ship.speed(_ANY_FROUDE, model.water.g) if speed is None else speed
    ready, values = prepare(model, at), model.values_at(at)
    effects, extra, rates = _effects(model, ready, values)
    states = _states(ready)
    inputs = ["delta_c", "n_c"] if ready.structure.revolutions else ["delta_c"]
    sections = [
        _inputs(states, inputs, about=about),
        _ship(model, ready.k[ready.place("wave_height")]),
        (
            f"Hull: {meaning(model)}. Source: {model.parts['hull_polynomial'].source}",
            _with_sources(
                model, POLYNOMIALS, hull_lines(values, model.convention, rolls=ready.rolls)
            ),
        ),
        *effects,
        (
            f"Mass and inertia. Source: {model.parts['added_mass'].source}",
            _with_sources(
                model,
                (INERTIA,),
                mass_lines(values[INERTIA], model.convention) + _levers(values[INERTIA]),
            ),
        ),
        (
            "Equations of motion about midship",
            motion_lines(values[INERTIA], extra, model.convention, rolls=ready.rolls),
        ),
        _steering(model),
        _path(states, rates, rolls=ready.rolls),
    ]
    called = f"{function}(x,ui{',U0' if approach else ''})"
    revolutions = (
        ready.self_propulsion() if speed is not None and ready.structure.revolutions else None
    )
    body = _alive(sections, ("xdot", "U"))
    used = frozenset().union(*(line.uses for _, own in body for line in own))
    lines = [
        f"function [xdot,U] = {called}",
        *heading(model, called, states, inputs, speed=speed, revolutions=revolutions, about=about),
        "",
        *_checks(states, inputs, speed=speed, revolutions=revolutions, approach=approach),
        *(text for title, own in body for text in _written(title, own)),
        "",
        "end",
        *(f"\n{text}" for name, text in _HELPERS.items() if name in used),
    ]
    return "\n".join(lines) + "\n"


def _check_speed(model: Model, speed: float | None, *, approach: bool) -> None:
    if speed is not None or not (model.Fn or approach):
        return
    why = f"has values at {len(model.Fn)} Froude numbers"
    if not model.Fn:
        why = "is written about the approach speed"
    raise ModelError(f"Model {model.name!r} {why}.", remedy=WHICH_SPEED)


def _states(ready: Prepared) -> list[str]:
    rolling = ["p", "phi"] if ready.rolls else []
    shaft = ["n"] if "n" in ready.structure.brought else []
    return ["u", "v", "r", "x", "y", "psi", *rolling, "delta", *shaft]


def _effects(
    model: Model, ready: Prepared, values: Mapping[str, Mapping[str, Any]]
) -> tuple[list[_Section], dict[str, list[str]], dict[str, str]]:
    """The effects besides the polynomials, their shares of the mass, the rates of their states."""
    problems: list[str] = []
    sections: list[_Section] = []
    extra: dict[str, list[str]] = {}
    rates: dict[str, str] = {}
    signals: dict[str, str] = {}
    if model.water.depth is not None:
        problems += [
            f"{name}: it changes derivatives by the depth." for name in model.in_role("depth")
        ]
    for item in ready.structure.used:
        if why := _unfit(item):
            problems.append(f"{item.effect}: {why}.")
            continue
        assert item.known.force is not None
        own = {name: f"{item.effect}_{name}" for name in item.own}
        bound = {**{name: signals.get(name, name) for name in item.arguments}, **own}
        try:
            lines, returned = transcribe(
                item.known.force,
                {**bound, **dict(item.options)},
                item.effect,
                tree=function_of_text(item.effect, item.text) if item.text else None,
            )
        except Unwritable as error:
            problems.append(f"{item.effect}: it is written with {error}.")
            continue
        head = [
            _parameter(item, name, values[item.effect].get(name, 0.0), model) for name in item.own
        ]
        for output, value in zip(item.known.outputs, returned, strict=True):
            if output in CHANNELS:
                lines.append(MatlabLine(output, Binary("+", Name(output), value)))
                continue
            name = value.word if isinstance(value, Name) else f"{item.effect}_{output}_out"
            if not isinstance(value, Name):
                lines.append(MatlabLine(name, value))
            if output in ACCELERATIONS:
                extra.setdefault(output, []).append(name)
            elif output.endswith("_rate"):
                rates[output[:-5]] = name
            else:
                signals[output] = name
        sections.append((_named(model, item), [*head, *lines]))
    if problems:
        found = [
            Problem(message=text, remedy="Leave it out to export the rest.") for text in problems
        ]
        raise ModelError(
            found, title=f"Model {model.name!r} is no function of states and inputs as in MSS"
        )
    return sections, extra, rates


def _unfit(item: Used) -> str | None:
    strange = [state for state in item.known.states if state != "n"]
    if strange:
        return f"it brings a state of its own ({', '.join(strange)})"
    lacking = dict.fromkeys(_NO_INPUT[name] for name in item.arguments if name in _NO_INPUT)
    return f"there is no input for {' and '.join(lacking)}" if lacking else None


def _parameter(item: Used, name: str, value: Any, model: Model) -> MatlabLine:
    known = item.known.parameter(name)
    assert known is not None
    unit = "" if known.unit == "-" else f" ({known.unit})"
    source = model.parts[item.effect].sources.get(name)
    note = known.text + unit + (f"; {source}" if source else "")
    return MatlabLine(f"{item.effect}_{name}", value, note)


def _with_sources(
    model: Model, effects: Iterable[str], lines: Iterable[MatlabLine]
) -> list[MatlabLine]:
    """Lines of derivatives with the source of those that have one of their own."""
    own = {
        variable(name): source
        for effect in effects
        if effect in model.parts
        for name, source in model.parts[effect].sources.items()
        if CATALOGUE[effect].parameter(name) is None
    }
    return [
        replace(line, note="; ".join(filter(None, (line.note, own[line.target]))))
        if line.target in own
        else line
        for line in lines
    ]


def _named(model: Model, item: Used) -> str:
    chosen = item.known.chosen(model.parts[item.effect].options)
    options = "".join(f", {name} {word}" for name, word in chosen.items())
    source = model.parts[item.effect].source
    return f"{item.effect}{options}: {item.known.summary} Source: {source or 'not stated'}"


def _inputs(states: Sequence[str], inputs: Sequence[str], *, about: bool) -> _Section:
    lines = []
    for place, name in enumerate(states):
        if name in ("x", "y"):
            continue
        text = f"x[{place}]"
        if name == "u" and about:
            text = f"U0 + {text}"
        lines.append(MatlabLine(name, f"{text}/60" if name == "n" else text))
    lines.append(MatlabLine("delta_c", "ui[0]"))
    if "n_c" in inputs:
        lines.append(MatlabLine("n_order", "ui[1]/60", "1/s"))
        if "n" not in states:
            lines.append(MatlabLine("n", "n_order"))
    lines += [
        MatlabLine("U", "max(sqrt(u**2 + v**2), 1e-9)", "speed (m/s)"),
        MatlabLine("beta", "atan2(-v, u)", "drift angle (rad)"),
    ]
    return ("States and inputs", lines)


def _ship(model: Model, sea: float) -> _Section:
    ship, water = model.ship, model.water
    lines = [
        MatlabLine(name, getattr(ship, name) or 0.0, text) for name, text in _PARTICULARS.items()
    ]
    depth = float("inf") if water.depth is None else water.depth
    lines += [
        MatlabLine("rho", water.rho, "density of the water (kg/m3)"),
        MatlabLine("g", water.g, "gravity (m/s2)"),
        MatlabLine("depth", depth, "of the water (m)"),
        MatlabLine("wave_height", sea, "no sea but that of the model (m)"),
        MatlabLine("wave_direction", 0.0, "where it comes from (rad)"),
        MatlabLine("Fn", "U/sqrt(g*L)", "Froude number"),
    ]
    return ("Ship and water", lines)


def _levers(added: Mapping[str, float]) -> list[MatlabLine]:
    known = CATALOGUE[INERTIA].parameter("lx")
    assert known is not None
    return [MatlabLine("lx", added.get("lx", 0.0), known.text)]


def _steering(model: Model) -> _Section:
    limits = model.steering
    lines = [
        MatlabLine(
            "delta_max",
            f"{float(limits.get('max_deg', 90.0))!r}*pi/180",
            "largest rudder angle (rad)",
        ),
        MatlabLine(
            "delta_rate",
            f"{float(limits['rate_deg_s'])!r}*pi/180",
            "rate of the steering gear (rad/s)",
        ),
        MatlabLine("T_delta", "1.0", "time constant near the order (s)"),
        MatlabLine("wanted", "max(min(delta_c, delta_max), -delta_max)"),
        MatlabLine("delta_dot", "max(min((wanted - delta)/T_delta, delta_rate), -delta_rate)"),
    ]
    return ("Steering gear", lines)


def _path(states: Sequence[str], rates: Mapping[str, str], *, rolls: bool) -> _Section:
    across = "v*cos(phi)" if rolls else "v"
    lines = [
        MatlabLine("x_dot", f"u*cos(psi) - {across}*sin(psi)"),
        MatlabLine("y_dot", f"u*sin(psi) + {across}*cos(psi)"),
        MatlabLine("psi_dot", "r*cos(phi)" if rolls else "r"),
    ]
    if rolls:
        lines.append(MatlabLine("phi_dot", "p"))
    if "n" in states:
        lines.append(MatlabLine("n_dot", f"60*{rates['n']}", "rpm/s"))
    lines.append(MatlabLine("xdot", f"column({', '.join(f'{name}_dot' for name in states)})"))
    return ("Time derivative of the states", lines)


def _alive(sections: Sequence[_Section], wanted: Iterable[str]) -> list[_Section]:
    """The sections with the lines on which something depends."""
    alive, kept = set(wanted), set()
    for line in reversed([x for _, lines in sections for x in lines]):
        if line.target in alive:
            alive.discard(line.target)
            alive |= line.uses
            kept.add(id(line))
    trimmed = [(title, [line for line in lines if id(line) in kept]) for title, lines in sections]
    return [section for section in trimmed if section[1]]


def _written(title: str, section: Sequence[MatlabLine]) -> list[str]:
    lines = ["", *comment(title)]
    for item in section:
        notes = comment(item.note) if item.note else []
        beside = f"{item.text:<38} {' '.join(notes)}".rstrip()
        if len(notes) < 2 and len(beside) <= _WIDTH + 20:
            lines.append(beside)
        else:
            lines += [*notes, *_wrapped(item.text)]
    return lines


def _wrapped(code: str) -> list[str]:
    """A long assignment over several lines, broken in front of signs and behind commas."""
    lines, current = [], ""
    for word in _BREAKS.split(code):
        if current.strip() and len(current) + len(word) > _WIDTH - 4:
            lines.append(f"{current.rstrip()} ...")
            current = "    "
        current += word.lstrip() if not current.strip() else word
    return [*lines, current]


def _checks(
    states: Sequence[str],
    inputs: Sequence[str],
    *,
    speed: float | None,
    revolutions: float | None,
    approach: bool,
) -> list[str]:
    lines = []
    if approach and speed is not None:
        lines.append(f"if nargin < 3, U0 = {matlab_value(speed)}; end")
    if revolutions is not None:
        lines.append(f"if length(ui) == 1, ui = [ui; {matlab_value(60 * revolutions)}]; end")
    return [
        *lines,
        f"if length(x) ~= {len(states)}, error('x-vector must have dimension {len(states)}!'); end",
        f"if length(ui) ~= {len(inputs)}, error('ui must have dimension {len(inputs)}!'); end",
    ]
