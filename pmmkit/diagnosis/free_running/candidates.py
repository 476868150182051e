"""What may be missing of a free-running ship's model: terms to add, values to free, faults."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Final, Literal

from pmmkit.conventions import force_unit, speed_unit
from pmmkit.effects.catalogue import catalogue
from pmmkit.identification.record import FreeRecord
from pmmkit.models import Model, Part

RUDDER_ZERO: Final = "rudder_zero"
"""The angle that a rudder column shows too little [rad]; no value of a model."""
CURRENT: Final = ("current_x", "current_y")


@dataclass(frozen=True, kw_only=True)
class FreeCandidate:
    """One effect, or one fault, as directions in which the values of a model may move.

    Parameters
    ----------
    name, family : str
        Name in the catalogue; family by which an answer is given first.
    kind : {"physics", "fault"}
        Whether it is the ship and its surroundings, or a measurement.
    summary : str
        One sentence for people.
    moves : mapping of str to Mapping of str to float
        By coefficient: which values of the model it moves, and by how much for a coefficient of 1.
        Values are named as in `identify`, with ``current_x``, ``current_y`` and ``rudder_zero``.
    typical : mapping of str to float
        Usual size of each coefficient.
    part : Part, optional
        What the model is given to have these values, where it lacks them.
    check : str
        A run that tells it from others, in words.
    source : str
        Where the usual sizes come from.
    """

    name: str
    family: str
    summary: str
    moves: Mapping[str, Mapping[str, float]]
    typical: Mapping[str, float]
    kind: Literal["physics", "fault"] = "physics"
    part: Part | None = None
    check: str = ""
    source: str = ""

    @property
    def values(self) -> tuple[str, ...]:
        """All values that it moves."""
        return tuple(dict.fromkeys(name for own in self.moves.values() for name in own))

    def added_to(self, model: Model) -> Model:
        """The model with a place for the effect, its size still zero."""
        made = model
        if self.part is not None and self.part.effect not in model.parts:
            made = replace(
                model, parts=MappingProxyType({**model.parts, self.part.effect: self.part})
            )
        for name in self.values:
            if "." in name or name in (*CURRENT, RUDDER_ZERO) or _known(made, name):
                continue
            home = "added_mass" if name.endswith("dot") else "hull_polynomial"
            made = made.with_values(home, **{name: 0.0})
        return made


def _known(model: Model, name: str) -> bool:
    return any(
        name in model.parts[part].values
        for part in ("hull_polynomial", "rudder_abkowitz", "added_mass")
        if part in model.parts
    )


def candidates_for(
    model: Model, records: Sequence[FreeRecord], *, windage: tuple[float, float] | None = None
) -> tuple[FreeCandidate, ...]:
    """Everything that may be missing of a model, as far as it has a place for it.

    Parameters
    ----------
    model : Model
        Complete.
    records : sequence of FreeRecord
        Whether they hold a wind.
    windage : (float, float), optional
        Frontal and lateral area above water [m²]; those of the model's wind, else as large as the
        areas below water.

    Returns
    -------
    tuple of FreeCandidate

    Examples
    --------
    >>> from pmmkit.models import load_model
    >>> found = candidates_for(load_model("kvlcc2-l7"), [])
    >>> [item.name for item in found if item.family == "asymmetry"]
    ['asymmetry', 'even_hull_terms', 'fault_rudder_zero']
    """
    found = [*_hull(model), _cross_flow(), *_rudder(model), *_propeller(model), *_tests(model)]
    speeds = [record.speed for record in records]
    found.append(_current(sum(speeds) / len(speeds) if speeds else 1.0))
    if records and all(record.wind_speed is not None for record in records):
        found.append(_wind(model, windage))
    return tuple(found)


def _terms(
    model: Model,
    name: str,
    family: str,
    summary: str,
    sizes: Mapping[str, float],
    *,
    check: str,
    source: str = "Son and Nomoto 1981, S175",
) -> FreeCandidate:
    """Derivatives with sizes over ½ρL²U² (½ρL³U²), carried to the system of the model."""
    convention, ship, water = model.convention, model.ship, model.water
    U = speed_unit(convention.system, L=ship.L, g=water.g, U=1.0)
    shape = {"L": ship.L, "d": ship.d, "volume": ship.volume, "rho": water.rho, "g": water.g}
    typical = {
        label: size
        * force_unit(label[0], "prime", U=U, **shape)
        / force_unit(label[0], convention.system, U=1.0, **shape)
        for label, size in sizes.items()
    }
    return FreeCandidate(
        name=name,
        family=family,
        summary=summary,
        moves={label: {label: 1.0} for label in sizes},
        typical=typical,
        check=check,
        source=source,
    )


def _hull(model: Model) -> list[FreeCandidate]:
    """Polynomial terms, sizes as in the contest of captive tests."""
    return [
        _terms(
            model,
            "asymmetry",
            "asymmetry",
            "A constant side force and moment, with the square of the speed.",
            {"Y0": 1.0e-4, "N0": -4.5e-5},
            check="a straight run without the propeller, or a captive run at rudder amidships",
        ),
        _terms(
            model,
            "even_hull_terms",
            "asymmetry",
            "Forces that are the same to port and to starboard.",
            {"Yvv": 0.003, "Nvv": 0.0004, "Yrr": 0.001, "Nrr": -0.0003},
            check="captive static drift to both sides",
        ),
        FreeCandidate(
            name="fault_rudder_zero",
            family="asymmetry",
            kind="fault",
            summary="The rudder column is off by a constant angle.",
            moves={RUDDER_ZERO: {RUDDER_ZERO: 1.0}},
            typical={RUDDER_ZERO: math.radians(0.5)},
            check="the rudder against a template, or a straight run with the propeller stopped",
            source="ITTC 7.5-02-06-04: 0.2 to 1°",
        ),
        _terms(
            model,
            "modulus_sway_drag",
            "cross flow",
            "Drag of sway with the square of its velocity.",
            {"Yv|v|": -0.020, "Nv|v|": 0.004},
            check="captive static drift at 15 to 25°",
        ),
        _terms(
            model,
            "modulus_yaw_drag",
            "cross flow",
            "Drag of yaw with the square of its rate.",
            {"Yr|r|": 0.0022, "Nr|r|": -0.0017},
            check="captive pure yaw at r' 0.8",
        ),
        _terms(
            model,
            "yaw_sway_coupling",
            "hull coupling",
            "Products of sway and yaw in side force and moment.",
            {"Yvvr": 0.0214, "Yvrr": -0.0405, "Nvvr": -0.0424, "Nvrr": 0.00156},
            check="captive yaw with drift at two drift angles of both signs",
        ),
        _terms(
            model,
            "surge_yaw_coupling",
            "surge",
            "Surge force of sway and yaw together.",
            {"Xvr": 0.0039},
            check="captive yaw with drift, surge force",
        ),
        _terms(
            model,
            "surge_quadratic",
            "surge",
            "Surge force of sway and of yaw alone.",
            {"Xvv": -0.0039, "Xrr": 0.0005},
            check="captive static drift and pure yaw, surge force",
        ),
        _terms(
            model,
            "surge_fourth_order",
            "surge",
            "Surge force with the fourth power of sway.",
            {"Xvvvv": 0.05},
            check="captive static drift to 20°",
        ),
        _terms(
            model,
            "acceleration_cross_terms",
            "inertia",
            "Side force of yaw acceleration, moment of sway acceleration.",
            {"Yrdot": -3.5e-4, "Nvdot": -3.5e-4},
            check="captive pure sway and pure yaw",
            source="Clarke et al. 1983",
        ),
        _terms(
            model,
            "rudder_stall",
            "rudder",
            "Rudder force that bends over at large angles.",
            {"Yddd": 0.0045, "Nddd": -0.0022},
            check="captive rudder at 25, 30 and 35°",
        ),
        _terms(
            model,
            "rudder_cross_terms",
            "rudder",
            "Rudder force that changes with drift.",
            {"Yvvd": -0.06, "Yvdd": 0.02, "Nvvd": 0.03, "Nvdd": -0.01},
            check="captive drift with rudder at both signs of each",
        ),
    ]


def _cross_flow() -> FreeCandidate:
    part = Part(effect="crossflow_drag", values=MappingProxyType({"CD": 0.0}), source="candidate")
    return FreeCandidate(
        name="crossflow_drag",
        family="cross flow",
        part=part,
        summary="Drag of the flow across each section, in one proportion of force and moment.",
        moves={"crossflow_drag.CD": {"crossflow_drag.CD": 1.0}},
        typical={"crossflow_drag.CD": 0.55},
        check="captive yaw with drift at large r/v",
        source="Hooft 1994",
    )


def _freed(
    model: Model,
    effect: str,
    name: str,
    family: str,
    summary: str,
    sizes: Mapping[str, float],
    *,
    check: str,
    source: str = "Yasukawa and Yoshimura 2015; Son and Nomoto 1981",
) -> list[FreeCandidate]:
    """Values of a part that may be far from what is known of them; none where it lacks them all."""
    if effect not in model.parts:
        return []
    known, part = catalogue()[effect], model.parts[effect]
    chosen = known.chosen(part.options)
    usable = {}
    for own, size in sizes.items():
        parameter = known.parameter(own)
        fits = parameter is not None and (
            parameter.form is None or chosen[parameter.form[0]] in parameter.form[1:]
        )
        if fits:
            usable[f"{effect}.{own}"] = size
    if not usable:
        return []
    return [
        FreeCandidate(
            name=name,
            family=family,
            summary=summary,
            typical=usable,
            check=check,
            source=source,
            moves={label: {label: 1.0} for label in usable},
        )
    ]


def _rudder(model: Model) -> list[FreeCandidate]:
    return [
        *_freed(
            model,
            "rudder_mmg",
            "flow_straightening",
            "rudder",
            "How much of the flow across the stern the rudder feels, to port and to starboard.",
            {"gamma_positive": 0.15, "gamma_negative": 0.15, "lR": 0.2, "gamma": 0.1, "cRr": 0.1},
            check="captive drift with rudder at the four corners ±β, ±δ",
        ),
        *_freed(
            model,
            "rudder_mmg",
            "rudder_slipstream",
            "rudder",
            "Speed of the flow at the rudder behind the propeller.",
            {"epsilon": 0.15, "kappa": 0.15},
            check="captive rudder at three propeller loads",
        ),
        *_freed(
            model,
            "rudder_mmg",
            "rudder_hull_interaction",
            "rudder",
            "Force that the rudder raises on the hull.",
            {"aH": 0.1, "xH": 0.15, "tR": 0.1},
            check="captive rudder with a rudder gauge",
        ),
    ]


def _propeller(model: Model) -> list[FreeCandidate]:
    resistance = "Xuu" if _known(model, "Xuu") else "Xu"
    found = [
        *_freed(
            model,
            "propeller",
            "wake_in_drift",
            "propeller",
            "Flow into the propeller in drift and turn.",
            {"C2_positive": 0.3, "C2_negative": 0.3, "tau": 0.4, "cp": 0.3},
            check="captive drift with the thrust measured",
        ),
        *_freed(
            model,
            "propeller",
            "propeller_load",
            "propeller",
            "Thrust at the revolutions of the runs: wake and thrust deduction.",
            {"wp": 0.08, "t": 0.05},
            check="captive straight runs at three revolutions",
        ),
    ]
    if _known(model, resistance):
        size = abs(_value(model, resistance))
        found.append(
            FreeCandidate(
                name="scale_effect",
                family="propeller",
                summary="Resistance of another scale or surface.",
                moves={resistance: {resistance: 1.0}},
                typical={resistance: 0.15 * size or 1e-4},
                check="a resistance test of this model",
                source="ITTC 1978",
            )
        )
    return found


def _value(model: Model, name: str) -> float:
    for part in ("hull_polynomial", "added_mass"):
        value = model.parts[part].values.get(name)
        if value is not None:
            return float(value[len(value) // 2]) if isinstance(value, tuple) else float(value)
    return 0.0


def _tests(model: Model) -> list[FreeCandidate]:
    """Faults of the captive tests that a model was made from; each has one size."""
    hull, added = model.parts["hull_polynomial"].values, model.parts["added_mass"].values
    arm = {
        f"N{name[1:]}": _value(model, name)
        for name in (*hull, *added)
        if name[0] == "Y" and _known(model, f"N{name[1:]}") and _value(model, name)
    }
    found = []
    if "Nv" in arm:
        found.append(
            FreeCandidate(
                name="fault_moment_point",
                family="captive tests",
                kind="fault",
                summary="The captive moments refer to another point than stated, x/L forward.",
                moves={"point": arm},
                typical={"point": 0.01},
                check="a captive run with a weight at a known lever",
                source="0.5 to 1 % of L",
            )
        )
    inertia = {
        name: {name: value}
        for name in ("Xudot", "Yvdot", "Nrdot")
        if (value := _value(model, name))
    }
    if inertia:
        found.append(
            FreeCandidate(
                name="fault_inertia",
                family="inertia",
                kind="fault",
                summary="Mass, moment of inertia or added mass are off, by a share.",
                moves=inertia,
                typical=dict.fromkeys(inertia, 0.05),
                check="swing the model; captive pure sway and yaw at three frequencies",
                source="ITTC 7.5-02-06-04, strip theory within 5 to 10 %",
            )
        )
    return found


def _current(speed: float) -> FreeCandidate:
    return FreeCandidate(
        name="current",
        family="surroundings",
        summary="A uniform current, the same in all runs.",
        moves={name: {name: 1.0} for name in CURRENT},
        typical=dict.fromkeys(CURRENT, 0.03 * speed),
        check="the same run on two headings",
        source="ITTC 7.5-04-02-01",
    )


def _wind(model: Model, windage: tuple[float, float] | None) -> FreeCandidate:
    ship = model.ship
    front, side = windage or (ship.B * ship.d, ship.L * ship.d)
    part = Part(
        effect="wind",
        source="candidate",
        values=MappingProxyType({"AF": front, "AL": side, "cx": 0.0, "cy": 0.0, "cn": 0.0}),
    )
    sizes = {"wind.cx": 0.7, "wind.cy": 0.8, "wind.cn": 0.1}
    return FreeCandidate(
        name="wind",
        family="surroundings",
        part=part,
        typical=sizes,
        summary="Force of the measured wind on the ship above water.",
        moves={name: {name: 1.0} for name in sizes},
        check="the same run in a calm",
        source="Fossen 2011, section 8.1",
    )
