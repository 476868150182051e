"""Roll for a model without it: the side forces act at levers that the measured heel shows."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Final

import numpy as np

from pmmkit.base import DataError, ModelError, Problem, Remedy, Way
from pmmkit.conventions import Ship, parse_derivative
from pmmkit.effects import HULL, INERTIA, AddedMass
from pmmkit.equations import prepare
from pmmkit.identification.record import FreeRecord
from pmmkit.identification.smoother import Smoothed
from pmmkit.models import Model, Part, Step
from pmmkit.numerics import Array

ADDED_INERTIA: Final = 0.2
"""Roll inertia of the water over that of the ship; S175 of the library: 0.19."""
DAMPING: Final = (0.005, 0.8)
"""Shares of the critical damping between which that of the records is looked for."""
LEVER: Final = "zR"
"""What an effect that steers calls the depth of its side force below the origin, over L."""


STATED: Final = MappingProxyType({"GM": "GM", "Ixx": "Ix"})
"""What a campaign file calls them."""
LEVERS: Final = ("hull", "added", "rudder")
"""Side forces that act at a depth of their own: of the hull, its added mass, the rudder."""


@dataclass(frozen=True)
class _Levers:
    """Depths of the side forces below the origin over L, and damping over the critical one."""

    hull: float = 0.0
    added: float = 0.0
    rudder: float = 0.0
    damping: float = 0.0


def with_roll(
    model: Model,
    records: Sequence[FreeRecord],
    *,
    GM: float | None = None,
    Ixx: float | None = None,
    sensors: Mapping[str, float] | None = None,
) -> Model:
    """A model that rolls, from one that does not and the heel of free-running records.

    Parameters
    ----------
    model : Model
        Complete but for roll; it may have derivatives of the heel.
    records : sequence of FreeRecord
        With a measured roll, as `free_records` takes it over.
    GM, Ixx : float, optional
        Metacentric height [m] and roll inertia [kg m²]; by default those that the ship states.
    sensors : mapping of str to float, optional
        As for `smooth`.

    Returns
    -------
    Model
        Its derivatives of K are those of Y times a lever: one for the hull, one for its added mass,
        one for the rudder; its part ``roll`` has the damping. Effects without a roll moment add
        none. Undoing the step takes all of it out.

    Raises
    ------
    ModelError
        If the model rolls already, or the ship states no GM or Ixx.
    DataError
        If no record has a measured roll.

    Notes
    -----
    K = -zH Y of the hull - zA Y of its added mass - zR Y of the rudder, as Son and Nomoto (1981)
    have it: 0.026, 0.031 and 0.033 of the length of their container ship. Along the motion that the
    sensors saw, the heel is the response of (Ixx + Jx) φ̈ + B φ̇ + ρ g ∇ GM φ = K, linear in the
    levers and in the heel and roll rate at the begin; they come from least squares, B from a
    search. The inertia of the water, Jx, is taken as 0.2 Ixx. With a wrong GM the levers are wrong
    by the same share and the steady heel is right.

    Examples
    --------
    >>> from pmmkit.models import load_model
    >>> with_roll(load_model("s175-3dof"), [])
    Traceback (most recent call last):
        ...
    pmmkit.base.errors.ModelError: Ship S175 of model 's175-3dof' states no GM and no Ixx, without \
which its heel cannot follow from the forces. State them: GM=… and Ixx=….
    """
    if model.rolls:
        raise ModelError(f"Model {model.name!r} rolls already.")
    made = replace(model, ship=_stable(model, GM, Ixx))
    seen = [item for item in records if item.roll is not None]
    if not seen:
        raise DataError(
            "No record has a measured roll (the column phi of a run), which roll is taken from."
        )
    smoothed = Smoothed.references(made, seen, sensors=sensors)
    histories = [_history(made, item) for item in smoothed]
    levers, rms = _fitted(made, histories)
    found = _rolling(made, levers)
    return found.stepped(
        Step(
            action="effect_added",
            effect="roll",
            coefficients=MappingProxyType({"damping": found.values("roll")["damping"]}),
            numbers=MappingProxyType(
                {f"{name}_lever": getattr(levers, name) * made.ship.L for name in LEVERS}
            ),
            source=f"heel of {len(seen)} records",
            note=f"the heel of {len(seen)} records follows to {math.degrees(rms):.2g}° (rms)",
            before=model.before(found),
        )
    )


def _stable(model: Model, GM: float | None, Ixx: float | None) -> Ship:
    """The ship with what its heel follows from."""
    ship = replace(
        model.ship,
        GM=model.ship.GM if GM is None else GM,
        Ixx=model.ship.Ixx if Ixx is None else Ixx,
    )
    lost = [name for name in ("GM", "Ixx") if not (getattr(ship, name) or 0.0) > 0.0]
    if lost:
        ways = tuple(
            Way(f"{name}=…", f"{STATED[name]} under [ship] of the campaign file") for name in lost
        )
        raise ModelError(
            Problem(
                message=f"Ship {ship.name} of model {model.name!r} states no "
                f"{' and no '.join(lost)}, without which its heel cannot follow from the forces.",
                remedy=Remedy(f"State them: {' and '.join('{}' for _ in lost)}.", ways),
            )
        )
    return ship


_History = tuple[Array, Array, tuple[Array, ...]]
"""Instants [s], heel [rad], roll moments [N m] of a record: without a lever, and of each."""


def _history(model: Model, smoothed: Smoothed) -> _History:
    """Roll moments along the motion of a record, righting, damping and inertia left out."""
    record, still = smoothed.record, np.zeros(len(smoothed.record))
    motion = {**smoothed.implied_forces(model).motion, "pdot": still}
    upright = {**motion, "phi": still, "p": still}

    def moment(levers: _Levers, along: Mapping[str, Array]) -> Array:
        made = _rolling(model, levers)
        ready = prepare(made, record.speed, conditions=record.conditions)
        return ready.water_forces(along)["K"]

    none = moment(_Levers(), motion)
    assert record.roll is not None
    known = moment(_Levers(), upright) - model.ship.rigid_body_forces(motion)["K"]
    by_lever = (moment(_Levers(**{name: 1.0}), motion) - none for name in LEVERS)
    return record.t - record.t[0], record.roll, (known, *by_lever)


def _fitted(model: Model, histories: Sequence[_History]) -> tuple[_Levers, float]:
    """Levers and damping of the least error of the heel, and that error [rad]."""
    from scipy.optimize import minimize_scalar

    heel = np.concatenate([own for _, own, _ in histories])

    def solved(share: float) -> tuple[Array, Array]:
        columns, known = [], []
        for i, (t, _, moments) in enumerate(histories):
            answers = _responses(model, t, moments, share)
            known.append(answers[0])
            free = np.zeros((len(t), 2 * len(histories)))
            free[:, 2 * i : 2 * i + 2] = answers[-2:].T
            columns.append(np.hstack([answers[1:-2].T, free]))
        design, left = np.concatenate(columns), heel - np.concatenate(known)
        size = np.maximum(np.linalg.norm(design, axis=0), 1e-300)
        found = np.linalg.lstsq(design / size, left, rcond=1e-8)[0] / size
        return found, left - design @ found

    best = minimize_scalar(
        lambda x: float(np.sum(solved(math.exp(x))[1] ** 2)),
        bounds=(math.log(DAMPING[0]), math.log(DAMPING[1])),
        method="bounded",
    )
    share = math.exp(best.x)
    found, left = solved(share)
    levers = _Levers(**dict(zip(LEVERS, found.tolist(), strict=False)), damping=share)
    return levers, float(np.sqrt(np.mean(left**2)))


def _stiffness(model: Model) -> tuple[float, float]:
    """Roll inertia with that of the water [kg m²], and righting moment per heel [N m]."""
    ship, water = model.ship, model.water
    assert ship.GM is not None
    assert ship.Ixx is not None
    return (1.0 + ADDED_INERTIA) * ship.Ixx, water.rho * water.g * ship.volume * ship.GM


def _responses(model: Model, t: Array, moments: Sequence[Array], share: float) -> Array:
    """Heel [rad] that each moment of a record gives, and the two free oscillations, (6, n)."""
    from scipy.signal import cont2discrete, lfilter

    inertia, righting = _stiffness(model)
    omega = math.sqrt(righting / inertia)
    even = np.linspace(0.0, t[-1], len(t))
    top, bottom, _ = cont2discrete(
        ([1.0 / inertia], [1.0, 2.0 * share * omega, omega**2]), even[1], method="foh"
    )
    forced = [
        np.interp(t, even, lfilter(np.ravel(top), bottom, np.interp(even, t, moment)))
        for moment in moments
    ]
    fading = np.exp(-share * omega * t)
    turning = omega * math.sqrt(1.0 - share**2) * t
    return np.stack([*forced, fading * np.cos(turning), fading * np.sin(turning)])


def _rolling(model: Model, levers: _Levers) -> Model:
    """The model with a part roll and the side forces at levers."""
    inertia, righting = _stiffness(model)
    parts = dict(model.parts)
    damping = 2.0 * levers.damping * math.sqrt(righting * inertia)
    origin = "identified: roll"
    parts["roll"] = Part(
        effect="roll", values=MappingProxyType({"damping": damping}), source=origin
    )
    for name, values in _moments(model, levers).items():
        part = parts[name]
        parts[name] = replace(
            part,
            values=MappingProxyType({**part.values, **values}),
            sources=MappingProxyType({**part.sources, **dict.fromkeys(values, origin)}),
        )
    return replace(model, parts=MappingProxyType(parts))


def _moments(model: Model, levers: _Levers) -> dict[str, dict[str, float | tuple[float, ...]]]:
    """Values of the roll moment by part: derivatives of Y times their levers."""
    found: dict[str, dict[str, float | tuple[float, ...]]] = {}
    ship = model.ship
    for part in (HULL, "rudder_abkowitz", INERTIA):
        for name, value in (model.parts[part].values if part in model.parts else {}).items():
            if name[0] != "Y":
                continue
            steered = parse_derivative(name).count("d")
            lever = levers.rudder if steered else levers.added if part == INERTIA else levers.hull
            found.setdefault(part, {})[f"K{name[1:]}"] = _times(-lever, value)
    mass = found.setdefault(INERTIA, {})
    mirrored = -1.0 if model.convention.sway == "beta" else 1.0
    if "Kvdot" in mass:
        mass["Ypdot"] = _times(mirrored, mass["Kvdot"])
    if "Krdot" in mass:
        mass["Npdot"] = mass["Krdot"]
    if model.convention.coriolis == "separate":
        mass["lx"] = levers.added
    unit = AddedMass.unit("Kpdot", ship=ship, water=model.water, convention=model.convention)
    mass["Kpdot"] = -ADDED_INERTIA * (ship.Ixx or 0.0) / unit
    for name in _steering(model):
        found[name] = {LEVER: levers.rudder}
    return found


def _steering(model: Model) -> tuple[str, ...]:
    """Parts with a lever of their side force."""
    return tuple(
        name for name, part in model.parts.items() if part.known.parameter(LEVER) is not None
    )


def _times(factor: float, value: float | tuple[float, ...]) -> float | tuple[float, ...]:
    return tuple(factor * x for x in value) if isinstance(value, tuple) else factor * value
