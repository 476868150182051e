"""The turn of a KVLCC2 by solvers of other people: heyoka (Taylor series) and numbalsoda.

The equations are the published ones of MMG (Yasukawa and Yoshimura 2015), written once: heyoka
makes expressions of them, numba machine code. Hull derivatives, one set for each ship, are given
when it sails. Neither solver looks for self-propulsion, headings or the end of the manoeuvre: the
ships sail for a given time, at given revolutions.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np

import pmmkit as pk

HULL = (
    *("Xuu", "Xvv", "Xvr", "Xrr", "Xvvvv"),
    *("Yv", "Yr", "Yvvv", "Yvvr", "Yvrr", "Yrrr"),
    *("Nv", "Nr", "Nvvv", "Nvvr", "Nvrr", "Nrrr"),
)
Ways = dict[str, Callable[[np.ndarray], np.ndarray]]
"""Solvers by name; each gives the states at the end (ships, 6) of derivatives (ships, `HULL`)."""


@dataclass(frozen=True)
class Turn:
    """What is sailed: approach [m/s], revolutions [1/s], rudder [rad] and its rate [rad/s]."""

    model: pk.Model
    speed: float
    n: float
    duration: float
    rtol: float
    order: float = math.radians(35.0)

    @property
    def rate(self) -> float:
        """Of the rudder."""
        return math.radians(self.model.values("rudder_mmg")["rate_deg_s"])

    @property
    def hull(self) -> np.ndarray:
        """The derivatives of `HULL`."""
        values = self.model.values("hull_polynomial")
        return np.array([values[name] for name in HULL])


def equations(model: pk.Model, words: Any) -> Callable[..., tuple[Any, ...]]:
    """Rates of x, y, ψ, u, v, r by the functions of a solver, which `words` holds."""
    sin, cos, atan2, sqrt, exp = words.sin, words.cos, words.atan2, words.sqrt, words.exp
    choose = words.choose
    ship, rho = model.ship, model.water.rho
    screw, blade = model.values("propeller"), model.values("rudder_mmg")
    added = model.values("added_mass")
    L, mass, xG = ship.L, ship.mass, ship.xG
    unit = 0.5 * rho * L * ship.d
    mx, my = -added["Xudot"] * unit * L, -added["Yvdot"] * unit * L
    mv, mr = mass + my, ship.Izz - added["Nrdot"] * unit * L**3
    mvr, det = mass * xG, (mass + my) * (ship.Izz - added["Nrdot"] * unit * L**3) - (mass * xG) ** 2
    D, t, wp, xp = (screw[name] for name in ("D", "t", "wp", "xp"))
    kt0, kt1, kt2 = screw["kt0"], screw["kt1"], screw["kt2"]
    C1, C2p, C2n = screw["C1"], screw["C2_positive"], screw["C2_negative"]
    slope = 0.5 * rho * blade["area"] * blade["lift_slope"]
    eps, kappa, eta, lR, tR = (blade[name] for name in ("epsilon", "kappa", "eta", "lR", "tR"))
    gp, gn, aH = blade["gamma_positive"], blade["gamma_negative"], blade["aH"]
    arm = (blade["xR"] + aH * blade["xH"]) * L

    def rates(psi, u, v, r, delta, n, h):  # type: ignore[no-untyped-def]
        U = sqrt(u * u + v * v)
        a, b = v / U, r * L / U
        s = unit * U * U
        X = s * (h[0] + h[1] * a * a + h[2] * a * b + h[3] * b * b + h[4] * a * a * a * a)
        Y = h[5] * a + h[6] * b + a * (h[7] * a * a + h[8] * a * b + h[9] * b * b)
        Y = s * (Y + h[10] * b * b * b)
        N = h[11] * a + h[12] * b + a * (h[13] * a * a + h[14] * a * b + h[15] * b * b)
        N = s * L * (N + h[16] * b * b * b)
        beta = atan2(-v, u)
        bp = beta - xp * b
        size, c2 = choose(bp, bp, -bp), choose(bp, C2p, C2n)
        uP = u * (1.0 - wp) * (1.0 + (1.0 - exp(-C1 * size)) * (c2 - 1.0))
        load = kt0 * n * n * D * D + kt1 * n * D * uP + kt2 * uP * uP
        X += (1.0 - t) * rho * D * D * load
        mixed = uP + kappa * (sqrt(uP * uP + 8.0 / math.pi * load) - uP)
        uR = eps * sqrt(eta * mixed * mixed + (1.0 - eta) * uP * uP)
        bR = beta - lR * b
        vR = -choose(bR, gp, gn) * bR * U
        FN = -slope * sqrt(uR * uR + vR * vR) * (uR * sin(delta) + vR * cos(delta))
        X += (1.0 - tR) * FN * sin(delta) + mv * v * r + mvr * r * r
        Y += (1.0 + aH) * FN * cos(delta) - (mass + mx) * u * r
        N += arm * FN * cos(delta) - mvr * u * r
        return (
            u * cos(psi) - v * sin(psi),
            u * sin(psi) + v * cos(psi),
            r,
            X / (mass + mx),
            (mr * Y - mvr * N) / det,
            (mv * N - mvr * Y) / det,
        )

    return rates


def heyoka(turn: Turn) -> Ways:
    """By heyoka, ship by ship and as many ships at once as the processor has lanes."""
    import heyoka as hy

    names = ("x", "y", "psi", "u", "v", "r")
    words = SimpleNamespace(
        **{name: getattr(hy, name) for name in ("sin", "cos", "atan2", "sqrt", "exp")},
        choose=lambda x, yes, no: hy.select(hy.gt(x, 0.0), yes + 0.0 * x, no + 0.0 * x),
    )
    states = hy.make_vars(*names)
    # The rudder moves in a stretch of its own: series want smooth equations.
    delta, hull = hy.par[0] + hy.par[1] * hy.time, [hy.par[2 + i] for i in range(len(HULL))]
    found = equations(turn.model, words)(*states[2:], delta, turn.n, hull)
    system = list(zip(states, found, strict=True))
    moved = turn.order / turn.rate
    begin = np.array([0.0, 0.0, 0.0, turn.speed, 0.0, 0.0])
    alone = hy.taylor_adaptive(system, begin.tolist(), tol=turn.rtol)
    lanes = hy.recommended_simd_size()
    begins = np.repeat(begin[:, None], lanes, axis=1)
    together = hy.taylor_adaptive_batch(system, begins.copy(), tol=turn.rtol)

    def sail(solver: Any, start: np.ndarray, hulls: np.ndarray) -> np.ndarray:
        solver.state[:], solver.pars[2:] = start, hulls
        for order, rate, end in ((0.0, turn.rate, moved), (turn.order, 0.0, turn.duration)):
            solver.pars[0], solver.pars[1] = order, rate
            solver.propagate_until(end)
        return solver.state

    def one_by_one(hulls: np.ndarray) -> np.ndarray:
        ends = np.empty((len(hulls), 6))
        for ship, hull in enumerate(hulls):
            alone.time = 0.0
            ends[ship] = sail(alone, begin, hull)
        return ends

    def batches(hulls: np.ndarray) -> np.ndarray:
        ends = np.empty((len(hulls), 6))
        for first in range(0, len(hulls), lanes):
            last = np.minimum(np.arange(first, first + lanes), len(hulls) - 1)
            together.set_time(0.0)
            ends[last] = sail(together, begins, hulls[last].T).T
        return ends

    return {"heyoka": one_by_one, f"heyoka, batches of {lanes}": batches}


def numbalsoda(turn: Turn) -> Ways:
    """By numbalsoda: LSODA, and the method of order 8 of Dormand and Prince."""
    import numba
    import numbalsoda as solver

    @numba.njit
    def choose(x, yes, no):  # type: ignore[no-untyped-def]
        return yes if x > 0.0 else no

    names = ("sin", "cos", "atan2", "sqrt", "exp")
    words = SimpleNamespace(**{name: getattr(math, name) for name in names}, choose=choose)
    rates = numba.njit(equations(turn.model, words), error_model="numpy")
    rate, order, n, size = turn.rate, turn.order, turn.n, len(HULL)

    @numba.cfunc(solver.lsoda_sig)
    def system(t, y, out, given):  # type: ignore[no-untyped-def]
        hull = numba.carray(given, (size,))
        found = rates(y[2], y[3], y[4], y[5], min(rate * t, order), n, hull)
        out[0], out[1], out[2], out[3], out[4], out[5] = found

    address = system.address
    begin = np.array([0.0, 0.0, 0.0, turn.speed, 0.0, 0.0])
    instants, rtol, atol = np.array([0.0, turn.duration]), turn.rtol, 1e-2 * turn.rtol

    def way(solve: Any) -> Callable[[np.ndarray], np.ndarray]:
        @numba.njit
        def run(hulls):  # type: ignore[no-untyped-def]
            ends = np.empty((hulls.shape[0], 6))
            for ship in range(hulls.shape[0]):
                found, _ = solve(address, begin, instants, hulls[ship], rtol, atol)
                ends[ship] = found[-1]
            return ends

        return run  # type: ignore[no-any-return]

    return {"numbalsoda, LSODA": way(solver.lsoda), "numbalsoda, DOP853": way(solver.dop853)}


SOLVERS: Mapping[str, Callable[[Turn], Ways]] = {"heyoka": heyoka, "numbalsoda": numbalsoda}


def installed(turn: Turn) -> Ways:
    """What is at hand; of others it is said that they are left out."""
    found: Ways = {}
    for name, make in SOLVERS.items():
        try:
            found |= make(turn)
        except ImportError:
            print(f"{name} is not installed (pip install --group bench): left out")
    return found
