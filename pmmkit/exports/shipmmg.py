"""A model as parameters for the Python package shipmmg."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, Final

from pmmkit.base import ModelError, TableError
from pmmkit.effects import CATALOGUE, HULL, INERTIA
from pmmkit.equations import prepare
from pmmkit.exports.text import WHICH_SPEED, written_by
from pmmkit.models import Model, converted, from_values
from pmmkit.simulation import stability
from pmmkit.syntax import comment, plain

_FIRST: Final = "# -*- coding: ascii -*-"
"""First line of the file: it settles the encoding, whatever a later comment says of it."""
_HULL: Final = (
    "Xvv",
    "Xvr",
    "Xrr",
    "Xvvvv",
    "Yv",
    "Yr",
    "Yvvv",
    "Yvvr",
    "Yvrr",
    "Yrrr",
    "Nv",
    "Nr",
    "Nvvv",
    "Nvvr",
    "Nvrr",
    "Nrrr",
)
_ADDED: Final = ("Xudot", "Yvdot", "Nrdot")
_TAKEN: Final = frozenset({"Xuu", *_HULL, *_ADDED})
_PARTS: Final = (HULL, INERTIA, "propeller", "rudder_mmg")
_TITLE: Final = "shipmmg takes models of the structure mmg with propeller and rudder_mmg only"
_DIFFERENT: Final = (
    "What shipmmg 0.0.11 computes otherwise than pmmkit: the wake in a turn is "
    "wP = wP0 exp(-4 (beta - xP r')^2) whatever the model has; the drift angle and the speed U "
    "that makes v and r non-dimensional are those of v - x_G r. It knows no steering gear: give "
    "it the rudder angle over time, at most at rudder_rate and up to rudder_max."
)


def model_to_shipmmg(model: Model, *, speed: float | None = None) -> str:
    """The text of a Python module that builds shipmmg's parameter objects from a model.

    speed [m/s].

    Examples
    --------
    >>> from pmmkit.models import load_model
    >>> [line for line in model_to_shipmmg(load_model("kvlcc2-l7")).splitlines() if "N_vvr" in line]
    ['        "N_vvr_dash": -0.294,']
    """
    if model.Fn and speed is None:
        raise ModelError(
            f"Model {model.name!r} has values at {len(model.Fn)} Froude numbers.",
            remedy=WHICH_SPEED,
        )
    _check_parts(model)
    at = model.ship.speed(0.2, model.water.g) if speed is None else speed
    Fn = model.ship.froude(at, model.water.g)
    hull, screw, blade = (
        model.values(effect, Fn if model.Fn else None)
        for effect in (HULL, "propeller", "rudder_mmg")
    )
    mmg = _as_mmg(model, {**hull, **_derivatives(model, INERTIA, Fn)})
    limits = model.steering
    lines = [
        _FIRST,
        *written_by("#"),
        *comment(
            f"{model.title or model.name}: parameters for shipmmg "
            f"(https://github.com/ShipMMG/shipmmg), 3 degrees of freedom.",
            "#",
        ),
        *(comment(f"Scale: {model.scale}", "#") if model.scale else ()),
        *(
            line
            for effect in _PARTS
            for line in comment(f"Source of {effect}: {model.parts[effect].source}", "#")
        ),
        *comment(_DIFFERENT, "#"),
        "",
        *(["from shipmmg.kt import KTParams"] if speed is not None else []),
        "from shipmmg.mmg_3dof import Mmg3DofBasicParams, Mmg3DofManeuveringParams",
        "",
        *_built("basic_params", "Mmg3DofBasicParams", _basic(model, mmg, screw, blade)),
        *_built("maneuvering_params", "Mmg3DofManeuveringParams", _manoeuvring(mmg, screw)),
        f"rho = {model.water.rho!r}  # density of the water (kg/m3)",
        f"rudder_rate = {limits['rate_deg_s']!r}  # deg/s",
        f"rudder_max = {limits.get('max_deg', 90.0)!r}  # deg",
    ]
    if speed is not None:
        lines += _at_speed(model, speed)
    return "\n".join(lines) + "\n"


def _check_parts(model: Model) -> None:
    problems = []
    lacking = [effect for effect in _PARTS if effect not in model.parts]
    if lacking:
        problems.append(f"The model lacks {', '.join(lacking)}.")
    surplus = [effect for effect in model.parts if effect not in _PARTS]
    if surplus:
        problems.append(f"shipmmg has no place for {', '.join(surplus)}.")
    for effect, option, word in (
        ("propeller", "open_water", "polynomial"),
        ("rudder_mmg", "inflow", "mmg"),
        ("rudder_mmg", "stall", "none"),
    ):
        if effect in model.parts:
            chosen = model.parts[effect].known.chosen(model.parts[effect].options)[option]
            if chosen != word:
                problems.append(f"{option} of {effect} is {chosen!r}; shipmmg has {word!r} only.")
    if problems:
        raise ModelError(problems, title=_TITLE)


def _derivatives(model: Model, effect: str, Fn: float) -> dict[str, Any]:
    values = model.values(effect, Fn if model.Fn else None)
    known = CATALOGUE[effect]
    return {name: value for name, value in values.items() if known.parameter(name) is None}


def _as_mmg(model: Model, values: Mapping[str, float]) -> dict[str, float]:
    """The derivatives of hull and added mass as the MMG standard writes them."""
    table = from_values(values, ship=model.ship, water=model.water, convention=model.convention)
    try:
        found = converted(
            table, system="prime-d", surge="constant", coriolis="separate", sway="v"
        ).at()
    except TableError as error:
        raise ModelError(error.problems, title=_TITLE) from error
    strange = [name for name, value in found.items() if value and name not in _TAKEN]
    absent = [name for name in ("Xuu", *_ADDED) if name not in found]
    problems = []
    if model.convention.U == "carriage":
        problems.append("The derivatives are made non-dimensional with the carriage speed.")
    if strange:
        problems.append(f"shipmmg has no place for {', '.join(strange)}.")
    if absent:
        problems.append(f"The model lacks {', '.join(absent)}.")
    if problems:
        raise ModelError(problems, title=_TITLE)
    return found


def _basic(
    model: Model, mmg: Mapping[str, float], screw: Mapping[str, Any], blade: Mapping[str, Any]
) -> list[tuple[str, float, str]]:
    ship = model.ship
    unit = 0.5 * model.water.rho * ship.L**2 * ship.d
    return [
        ("L_pp", ship.L, "m"),
        ("B", ship.B, "m"),
        ("d", ship.d, "m"),
        ("x_G", ship.xG, "m, forward of midship"),
        ("D_p", screw["D"], "m"),
        ("m", ship.mass, "kg"),
        ("I_zG", ship.Izz - ship.mass * ship.xG**2, "kg m2, about the centre of gravity"),
        ("A_R", blade["area"], "m2"),
        ("η", blade["eta"], "eta, propeller diameter over rudder height"),
        ("m_x", -mmg["Xudot"] * unit, "kg"),
        ("m_y", -mmg["Yvdot"] * unit, "kg"),
        ("J_z", -mmg["Nrdot"] * unit * ship.L**2, "kg m2"),
        ("f_α", blade["lift_slope"], "f_alpha"),
        ("ε", blade["epsilon"], "epsilon"),
        ("t_R", blade["tR"], ""),
        ("x_R", blade["xR"] * ship.L, "m"),
        ("a_H", blade["aH"], ""),
        ("x_H", blade["xH"] * ship.L, "m"),
        ("γ_R_minus", blade["gamma_negative"], "gamma_R, beta_R < 0"),
        ("γ_R_plus", blade["gamma_positive"], "gamma_R, beta_R > 0"),
        ("l_R", blade["lR"], "over L"),
        ("κ", blade["kappa"], "kappa"),
        ("t_P", screw["t"], ""),
        ("w_P0", screw["wp"], ""),
        ("x_P", screw["xp"], "over L"),
    ]


def _manoeuvring(
    mmg: Mapping[str, float], screw: Mapping[str, Any]
) -> list[tuple[str, float, str]]:
    curve = [(f"k_{power}", screw[f"kt{power}"], "") for power in range(3)]
    hull = [(f"{name[0]}_{name[1:]}_dash", mmg.get(name, 0.0), "") for name in _HULL]
    return [*curve, ("R_0_dash", -mmg["Xuu"], ""), *hull]


def _built(target: str, kind: str, entries: Iterable[tuple[str, float, str]]) -> list[str]:
    """A call with keywords; a mapping, for some of shipmmg's names are not ASCII."""
    lines = [
        f'        "{name.encode("ascii", "backslashreplace").decode()}": {float(value)!r},'
        + (f"  # {plain(note)}" if note else "")
        for name, value, note in entries
    ]
    return [f"{target} = {kind}(", "    **{", *lines, "    }", ")"]


def _at_speed(model: Model, speed: float) -> list[str]:
    """What belongs to one approach speed."""
    found = stability(model, speed)
    pace = speed / model.ship.L
    return [
        "",
        *comment(f"At an approach speed of {speed:g} m/s.", "#"),
        f"u0 = {float(speed)!r}  # m/s",
        f"nps = {prepare(model, speed).self_propulsion()!r}  # 1/s, self-propulsion in pmmkit",
        f"kt_params = KTParams(K={found.K * pace!r}, T={found.T / pace!r})  # 1/s, s",
    ]
