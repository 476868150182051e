"""Propeller and rudder of the MMG model from captive tests, and the hull alone."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from pmmkit.base import MissingPartError
from pmmkit.effects import CATALOGUE, Effect, Regressors, State
from pmmkit.models import Part, straight_polynomial
from pmmkit.numerics import Array
from pmmkit.presentation import WIDE, Described, Grid, Group, Section, counted, plus_minus

if TYPE_CHECKING:
    from pmmkit.models import DerivativeTable
    from pmmkit.reduction.reduce import Reduction

FADES: Final = 2.0
"""C1 of the wake where the drift tests do not determine how fast it fades."""


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Parts(Described):
    """Propeller and rudder as the tests have them.

    Parameters
    ----------
    propeller, rudder : Part
        For a model; each value says whether it is measured or assumed.
    std : mapping of str to float
        Standard errors of the measured values, from the scatter.
    notes : tuple of str
        What could not be found and was assumed.
    runs : mapping of str to int
        How many runs each step rests on.
    """

    propeller: Part
    rudder: Part
    std: Mapping[str, float]
    notes: tuple[str, ...]
    runs: Mapping[str, int]

    @classmethod
    def of(
        cls,
        reduction: Reduction,
        *,
        area: float,
        height: float,
        lift_slope: float,
        lR: float,
        rate_deg_s: float,
        xR: float = -0.5,
        xp: float = -0.48,
        assumed: str = "assumed",
    ) -> Parts:
        """Propeller and rudder from thrust, rudder gauge and open-water curve.

        Parameters
        ----------
        reduction : Reduction
            Static rudder, static drift and drift-rudder tests with ``T``, ``FY_rudder`` and a
            turning propeller, and an open-water curve in the campaign file.
        area, height : float
            Rudder area [m²] and height [m].
        lift_slope : float
            Gradient of the rudder's normal force coefficient, from its aspect ratio: only its
            product with the square of the inflow is measured.
        lR : float
            Effective lever of the yaw rate at the rudder over L: static tests do not give it.
        rate_deg_s : float
            Rate of the steering gear [deg/s].
        xR, xp : float
            Rudder and propeller forward of midship over L.
        assumed : str
            Source of what is not measured, such as ``library: Yasukawa and Yoshimura 2015``.

        Raises
        ------
        MissingPartError
            If a test or a gauge is missing; the message says which.

        Notes
        -----
        KT from the open-water curve up to J = 0.8; the wake of each run by thrust identity, faded
        with drift by the two-sided form of Yasukawa and Yoshimura (2015); ε and κ from the slopes
        of the normal force over the rudder angle at all speeds (loadings) tested straight ahead;
        tR, aH, xH from X, Y, N over the measured normal force of those runs; γR of both sides from
        the normal force in drift.
        """
        from scipy.optimize import least_squares

        campaign = reduction.campaign
        D, L, rho = (
            float(campaign.propeller.get("D", math.nan)),
            campaign.ship.L,
            campaign.water.rho,
        )
        curve = campaign.open_water
        points = _points(reduction)
        straight = [p for p in points if p.v == 0.0]
        drifting = [p for p in points if p.v != 0.0]
        lacks = [
            text
            for text, there in (
                ("[propeller] D", math.isfinite(D)),
                ("[propeller] open_water (J, KT, KQ)", curve is not None),
                ("static_rudder runs with FY_rudder and T", len(straight) > 3),
                ("static_drift or drift_rudder runs with FY_rudder and T", len(drifting) > 3),
                ("straight runs with T and resistance tests", reduction.propulsion is not None),
            )
            if not there
        ]
        if lacks:
            raise MissingPartError(
                f"Propeller and rudder cannot be found without {'; '.join(lacks)}."
            )
        assert curve is not None
        assert reduction.propulsion is not None
        thrust = straight_polynomial(*curve)
        kt0, kt1, kt2 = thrust["kt0"], thrust["kt1"], thrust["kt2"]

        def inflow(p: _Point) -> float:
            """Water speed at the propeller by thrust identity [m/s]."""
            tip = p.n * D
            roots = np.roots([kt2, kt1 * tip, kt0 * tip * tip - p.thrust / (rho * D * D)])
            fit = [float(x.real) for x in roots if abs(x.imag) < 1e-9 and x.real > -tip]
            return min(fit, key=lambda x: abs(x - 0.6 * p.u))

        design = max((p.u for p in straight), default=0.0)
        wake = [1.0 - inflow(p) / p.u for p in straight if p.u == design]
        wp = float(np.mean(wake))
        grown = np.array([inflow(p) / p.u / (1.0 - wp) for p in drifting])
        drift = np.array([math.atan2(-p.v, p.u) for p in drifting])

        def faded(limits: Array) -> Array:
            limit = np.where(drift > 0, limits[0], limits[1])
            grows: Array = 1.0 + (1.0 - np.exp(-FADES * np.abs(drift))) * (limit - 1.0)
            return grows

        limits = least_squares(lambda x: faded(x) - grown, [1.5, 1.2])
        eta = D / height
        steering = CATALOGUE["rudder_mmg"]
        force = steering.force
        assert force is not None
        of_all = dict.fromkeys(steering.arguments, 0.0)
        of_all |= {"L": L, "rho": rho, "eta": eta, "lR": lR, "inflow": 1}
        of_all |= {"area": area, "lift_slope": lift_slope}

        def normal(
            p: _Point, eps: float, kappa: float, plus: float, minus: float, zero: float
        ) -> float:
            own = {
                "v": p.v,
                "beta": math.atan2(-p.v, p.u),
                "delta": p.delta + zero,
                "U": math.hypot(p.u, p.v),
                "propeller_inflow": inflow(p),
                "loading": p.thrust / (rho * D * D),
                "epsilon": eps,
                "kappa": kappa,
                "gamma_positive": plus,
                "gamma_negative": minus,
            }
            told: tuple[float, ...] = force(**(of_all | own))
            return told[-1]

        ahead = least_squares(
            lambda x: [normal(p, x[0], x[1], 0.5, 0.5, x[2]) - p.normal for p in straight],
            [1.0, 0.5, 0.0],
        )
        eps, kappa, zero = ahead.x.tolist()
        aside = least_squares(
            lambda x: [normal(p, eps, kappa, x[0], x[1], zero) - p.normal for p in drifting],
            [0.5, 0.5],
        )
        fast = [p for p in straight if p.u == design]
        drag = _line([-p.normal * math.sin(-p.delta) for p in fast], [p.force["X"] for p in fast])
        side = _line([p.normal * math.cos(p.delta) for p in fast], [p.force["Y"] for p in fast])
        turn = _line([p.normal * math.cos(p.delta) for p in fast], [p.force["N"] / L for p in fast])
        aH = side[0] - 1.0
        values = {
            "area": area,
            "lift_slope": lift_slope,
            "epsilon": eps,
            "kappa": kappa,
            "eta": eta,
            "gamma_positive": float(aside.x[0]),
            "gamma_negative": float(aside.x[1]),
            "lR": lR,
            "tR": 1.0 - drag[0],
            "aH": aH,
            "xH": (turn[0] - xR) / aH,
            "xR": xR,
            "rate_deg_s": rate_deg_s,
        }
        screw = {
            "D": D,
            "t": reduction.propulsion.thrust_deduction,
            "kt0": kt0,
            "kt1": kt1,
            "kt2": kt2,
            "wp": wp,
            "xp": xp,
            "C1": FADES,
            "C2_positive": float(limits.x[0]),
            "C2_negative": float(limits.x[1]),
        }
        measured = f"measured: {campaign.title}"
        lent = ("lift_slope", "lR", "xR", "rate_deg_s")
        return cls(
            propeller=Part(
                effect="propeller",
                values=MappingProxyType(screw),
                source=measured,
                options=MappingProxyType({"wake": "mmg"}),
                sources=MappingProxyType(dict.fromkeys(("xp", "C1"), assumed)),
            ),
            rudder=Part(
                effect="rudder_mmg",
                values=MappingProxyType(values),
                source=measured,
                options=MappingProxyType({"inflow": "mmg"}),
                sources=MappingProxyType(dict.fromkeys(lent, assumed)),
            ),
            std=MappingProxyType(
                {
                    **dict(zip(("epsilon", "kappa", "rudder_zero"), _errors(ahead), strict=True)),
                    **dict(zip(("gamma_positive", "gamma_negative"), _errors(aside), strict=True)),
                    **dict(zip(("C2_positive", "C2_negative"), _errors(limits), strict=True)),
                    "tR": drag[1],
                    "aH": side[1],
                    "t": reduction.propulsion.std,
                    "wp": float(np.std(wake)),
                }
            ),
            notes=(
                f"Assumed, because these tests do not give it: {', '.join((*lent, 'xp', 'C1'))}.",
                f"Rudder amidships stands at {math.degrees(zero):+.2f}° by its normal force; "
                "the model has none of that.",
            ),
            runs=MappingProxyType({"straight ahead": len(straight), "in drift": len(drifting)}),
        )

    def hull_alone(
        self,
        table: DerivativeTable,
        *,
        speed: float,
        revolutions: float,
        most_drift_deg: float = 20.0,
        most_yaw: float = 0.6,
    ) -> DerivativeTable:
        """Derivatives of the hull without the rudder, from those of a model tested with it.

        Parameters
        ----------
        table : DerivativeTable
            Of a model with rudder amidships and turning propeller, thrust apart (term ``XT``).
        speed, revolutions : float
            Of the tests [m/s], [1/s].
        most_drift_deg, most_yaw : float
            Range of drift [deg] and of r' over which the rudder's forces are fitted.

        Returns
        -------
        DerivativeTable
            The forces of the rudder amidships on a grid of motions are fitted by the table's own
            terms, and taken off. The covariance stays that of the table.
        """
        ship, water = table.ship, table.water
        drift, yaw = np.meshgrid(
            np.radians(np.linspace(-most_drift_deg, most_drift_deg, 21)),
            np.linspace(-most_yaw, most_yaw, 21),
        )
        u, v = speed * np.cos(drift.ravel()), -speed * np.sin(drift.ravel())
        state = State.of(u=u, v=v, r=yaw.ravel() * speed / ship.L)
        forces = rudder_amidships(self, state, ship.L, water.rho, revolutions)
        changed = np.array(table.value)
        names = [
            name
            for name in table.names
            if not any(factor in name[1:] for factor in ("d", "T")) and name not in ("Xuu", "X0")
        ]
        for channel, force in forces.items():
            chosen = [name for name in names if name[0] == channel]
            columns = Regressors.at(
                chosen,
                state,
                ship=ship,
                water=water,
                convention=table.convention,
                approach_speed=speed,
            ).columns
            size = np.linalg.norm(columns, axis=0)
            share = np.linalg.lstsq(columns / size, force, rcond=None)[0] / size
            for name, value in zip(chosen, share, strict=True):
                changed[:, table.index(name)] -= value
        return replace(
            table,
            value=changed,
            notes=(*table.notes, "Forces of the rudder amidships are taken off the hull."),
        )

    def _headline(self) -> str:
        both = (self.propeller, self.rudder)
        return " and ".join(
            f"{part.effect} ({counted(len(part.values), 'value')})" for part in both
        )

    def _sections(self) -> Sequence[Section]:
        groups = []
        for part in (self.propeller, self.rudder):
            rows = []
            for name, value in part.values.items():
                ends = value if isinstance(value, tuple) else (value,)
                std = self.std.get(name, math.nan)
                told = [plus_minus(x, WIDE * std) for x in (ends[0], ends[-1])]
                rows.append([name, " … ".join(dict.fromkeys(told)), part.source_of(name)])
            groups.append(Group(title=part.effect, rows=rows))
        head = ["", "value ± half of the 95 % interval", "source"]
        table = Grid(head=head, groups=groups, texts=(2,))
        steps = [f"{step}: {counted(count, 'run')}" for step, count in self.runs.items()]
        return [
            Section(tables=[table]),
            *([Section(title="Runs behind each step", points=steps)] if steps else []),
            *([Section(title="Notes", points=self.notes)] if self.notes else []),
        ]


@dataclass(frozen=True, kw_only=True)
class _Point:
    """One static run with propeller and rudder gauge, SI."""

    u: float
    v: float
    delta: float
    n: float
    thrust: float
    normal: float
    force: Mapping[str, float]


def rudder_amidships(
    parts: Parts, state: State, L: float, rho: float, revolutions: float
) -> dict[str, Array]:
    """X, Y [N] and N [N m] of the rudder at zero angle behind its propeller, over histories."""
    screw, blade = CATALOGUE["propeller"], CATALOGUE["rudder_mmg"]
    motion: dict[str, Any] = {
        "u": state.u,
        "v": state.v,
        "r": state.r,
        "beta": np.arctan2(-state.v, state.u),
        "U": state.speed,
        "L": L,
        "rho": rho,
    }
    _, inflow, _, _, loading = screw.force_over_arrays(
        n=revolutions, **_words(screw, parts.propeller, motion)
    )
    X, Y, N, _, _ = blade.force_over_arrays(
        delta=0.0, propeller_inflow=inflow, loading=loading, **_words(blade, parts.rudder, motion)
    )
    return {"X": X, "Y": Y, "N": N}


def _words(effect: Effect, part: Part, motion: Mapping[str, Any]) -> dict[str, Any]:
    """Arguments of an effect's function from a part and a motion."""
    asked = effect.arguments
    chosen = effect.chosen(part.options)
    given: dict[str, Any] = {name: motion[name] for name in asked if name in motion}
    for item in effect.parameters:
        if item.name in asked:
            blank: Any = (0.0, 1.0) if item.table else 0.0
            given[item.name] = part.values.get(item.name, item.default or blank)
    for name, words in effect.options.items():
        given[name] = words.index(chosen[name])
    return given


def _points(reduction: Reduction) -> list[_Point]:
    found = []
    for rows in reduction.rows:
        run, extras = rows.result.run, rows.result.extras
        here = run.settings
        turned = not run.kind_of_test.straight or here.heel
        if turned or not here.propeller_rps or not {"T", "FY_rudder"} <= set(extras):
            continue
        found.append(
            _Point(
                u=here.speed * math.cos(here.drift),
                v=-here.speed * math.sin(here.drift) if here.drift else 0.0,
                delta=here.rudder,
                n=here.propeller_rps,
                thrust=extras["T"],
                normal=extras["FY_rudder"],
                force={name: float(values[0]) for name, values in rows.force.items()},
            )
        )
    return found


def _line(x: Sequence[float], y: Sequence[float]) -> tuple[float, float]:
    """Slope of a straight line with free offset, and its standard error."""
    design = np.stack([np.asarray(x), np.ones(len(x))], axis=1)
    solution, *_ = np.linalg.lstsq(design, np.asarray(y), rcond=None)
    misfit = np.asarray(y) - design @ solution
    freedom = max(len(x) - 2, 1)
    spread = float(misfit @ misfit) / freedom * np.linalg.inv(design.T @ design)[0, 0]
    return float(solution[0]), math.sqrt(spread)


def _errors(fit: Any) -> list[float]:
    """Standard errors of a nonlinear fit, from its residuals."""
    freedom = max(len(fit.fun) - len(fit.x), 1)
    scale = float(fit.fun @ fit.fun) / freedom
    spread: list[float] = np.sqrt(scale * np.diagonal(np.linalg.inv(fit.jac.T @ fit.jac))).tolist()
    return spread
