"""What a kind of test is: its settings, what moves in it, and how its nominal motion goes.

The tank axes are x along the rails and y to starboard; the carriage runs at Uc; heading ψ to
starboard. Oscillations go with the phase θ = ωt + phase of the displacement.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from typing import ClassVar, Final, Literal

import numpy as np

from pmmkit.base import Registry
from pmmkit.campaigns.settings import Settings
from pmmkit.numerics import Array

# Two-strut mechanisms: where the hull is, from the positions of its two struts across the tank.
#
# Both struts stand on the carriage, b apart along the rails, and move across the tank. One is
# pivoted to the hull, the other slides along it, so that its heading on the struts is ψb =
# atan((yf - ya)/b) exactly. With yf = a sin(θs + ε/2), ya = a sin(θs - ε/2) the point midway goes
# A sin θs and tan ψb = K cos θs, with A = a cos(ε/2) and K = (2a/b) sin(ε/2) (Gertler 1959;
# Abkowitz 1964).


@dataclass(frozen=True, kw_only=True)
class Struts:
    """The two struts of a mechanism, ``[struts]`` of a campaign file.

    `spacing`: distance of the struts along the rails [m]. `centre_x`: where the point midway
    between them is at rest, forward of midship [m]. `slides`: the strut that slides along the
    hull; the other is pivoted to it. `motion_x`: the point whose motion is meant by the
    campaign, forward of midship [m].
    """

    spacing: float
    centre_x: float = 0.0
    slides: Literal["aft", "forward"] = "aft"
    motion_x: float = 0.0

    @property
    def signed(self) -> float:
        """The spacing, negative where the aft strut is pivoted [m]."""
        return self.spacing if self.slides == "aft" else -self.spacing

    @property
    def centre(self) -> float:
        """Where the point midway is, forward of the point whose motion is meant [m]."""
        return self.centre_x - self.motion_x

    def swing(self, amplitude: float, phase: float) -> tuple[float, float]:
        """Amplitude A of the point midway [m] and the largest heading atan K on the struts [rad].

        amplitude [m].

        Examples
        --------
        >>> Struts(spacing=2.0).swing(0.3, 0.0)
        (0.3, 0.0)
        >>> midway, heading = Struts(spacing=2.0).swing(0.3, math.pi)
        >>> round(midway, 9), round(math.tan(heading), 9)
        (0.0, 0.3)
        """
        half = phase / 2
        return (
            amplitude * math.cos(half),
            math.atan(2 * amplitude * math.sin(half) / self.spacing),
        )

    def of_pure_yaw(self, omega: float, speed: float) -> float:
        """Lead of the forward strut at which the hull follows its heading: 2 atan(ωb/2U) [rad].

        Examples
        --------
        >>> round(math.degrees(Struts(spacing=2.0).of_pure_yaw(0.6, 1.2)), 2)
        53.13
        """
        return 2 * math.atan(omega * self.spacing / (2 * speed))

    def amplitude_and_phase(self, settings: Settings, *, lags: bool) -> tuple[float, float]:
        """Amplitude of each strut [m] and lead of the forward one [rad]: undoes `swing`."""
        heading = (settings.yaw_amplitude or 0.0) * (-1 if lags else 1)
        across = 0.5 * self.spacing * math.tan(heading)
        along = settings.amplitude or 0.0
        return math.hypot(along, across), 2 * math.atan2(across, along)


def place_on_struts(
    y_forward: Array, y_aft: Array, struts: Struts, turned: float = 0.0
) -> dict[str, Array]:
    """Place and heading of the hull from the recorded positions of its struts.

    y_forward, y_aft [m].

    Examples
    --------
    >>> found = place_on_struts(np.array([0.1]), np.array([0.1]), Struts(spacing=2.0))
    >>> {name: x.tolist() for name, x in found.items()}
    {'x': [0.0], 'y': [0.1], 'psi': [0.0]}
    """
    bar = np.arctan((y_forward - y_aft) / struts.spacing)
    ahead, aside = _arm(struts.signed, struts.centre, turned)
    pivot = y_forward if struts.slides == "aft" else y_aft
    cosine, sine = np.cos(bar), np.sin(bar)
    return {
        "x": ahead * (cosine - 1.0) - aside * sine,
        "y": pivot + ahead * sine + aside * (cosine - 1.0),
        "psi": bar + turned,
    }


def swung(settings: Settings, theta: Array, *, lags: bool) -> Mapping[str, Array]:
    """Place, velocities and accelerations in tank axes of a hull on struts, exact in every
    angle."""
    spacing, omega = settings.strut_spacing or math.inf, settings.omega or 0.0
    sine, cosine = np.sin(theta), np.cos(theta)
    midway = settings.amplitude or 0.0
    slope = math.tan(settings.yaw_amplitude or 0.0) * (-1 if lags else 1)
    p, pdot, pddot = slope * cosine, -slope * omega * sine, -slope * omega**2 * cosine
    bar = np.arctan(p)
    r = pdot / (1.0 + p**2)
    rdot = pddot / (1.0 + p**2) - 2.0 * p * r**2
    ahead, aside = _arm(spacing, settings.strut_centre, settings.drift)
    c, s = np.cos(bar), np.sin(bar)
    along, across = ahead * c - aside * s, ahead * s + aside * c
    return {
        "x": along - ahead,
        "y": midway * sine + spacing / 2 * p + across - aside,
        "xdot": settings.speed - r * across,
        "ydot": midway * omega * cosine + spacing / 2 * pdot + r * along,
        "xddot": -rdot * across - r**2 * along,
        "yddot": -midway * omega**2 * sine + spacing / 2 * pddot + rdot * along - r**2 * across,
        "psi": bar + settings.drift,
        "r": r,
        "rdot": rdot,
    }


def _arm(spacing: float, centre: float, turned: float) -> tuple[float, float]:
    """From the pivot to the point whose motion is meant, along and across the line of struts."""
    return -spacing / 2 - centre * math.cos(turned), -centre * math.sin(turned)


Family = Literal["steady", "oscillating", "free-running"]


@dataclass(frozen=True, kw_only=True)
class TankMotion:
    """Velocities [m/s] and accelerations [m/s²] in tank axes, heading [rad] and its derivatives."""

    xdot: Array
    ydot: Array
    xddot: Array
    yddot: Array
    psi: Array
    r: Array
    rdot: Array

    @property
    def in_ship_axes(self) -> dict[str, Array]:
        """Ship-axes components and their own time derivatives."""
        cosine, sine = np.cos(self.psi), np.sin(self.psi)
        u = self.xdot * cosine + self.ydot * sine
        v = -self.xdot * sine + self.ydot * cosine
        return {
            "u": u,
            "v": v,
            "r": self.r,
            "udot": self.xddot * cosine + self.yddot * sine + self.r * v,
            "vdot": -self.xddot * sine + self.yddot * cosine - self.r * u,
            "rdot": self.rdot,
        }


ShipMotion = Mapping[str, float | Array]
"""Of ``u, v, r, udot, vdot, rdot``, and ``phi, p, pdot`` of a model that is rolled; those that are
absent are zero, and the heel is that which is held."""


@dataclass(frozen=True, kw_only=True)
class Swing:
    """A motion that oscillates.

    `displacement, velocity`: channels of the displacement (``x``, ``y``, ``psi``; ``delta`` of
    the rudder) and of its rate (``u``, ``v``, ``r``; empty for the rudder, whose rate is no
    channel). `amplitude`: the setting that is the amplitude of the displacement.
    """

    displacement: str
    velocity: str
    amplitude: str


SURGE: Final = Swing(displacement="x", velocity="u", amplitude="amplitude")
SWAY: Final = Swing(displacement="y", velocity="v", amplitude="amplitude")
YAW: Final = Swing(displacement="psi", velocity="r", amplitude="yaw_amplitude")
RUDDER: Final = Swing(displacement="delta", velocity="", amplitude="rudder_amplitude")


@dataclass(frozen=True, kw_only=True)
class PhaseChannel:
    """A channel that tells the phase θ of an oscillating test.

    `with_cosine`: whether it goes with cos θ, as velocities do; else with sin θ. `amplitude`:
    the setting whose sign it has.
    """

    channel: str
    with_cosine: bool
    amplitude: str


@dataclass(frozen=True, kw_only=True)
class NominalMotion:
    """How the model goes in a captive test, from the settings and the phases θ (n,) [rad].

    `tank`: motion in tank axes. Amplitudes that are not stated count as zero. `ship`: the same
    in ship axes where it is known in closed form; else it follows from `tank`. `place`: where
    the hull is, x and y from where it lies at rest [m], in axes that move with the carriage.
    Absent where settings and phase do not tell it.
    """

    tank: Callable[[Settings, Array], TankMotion] | None = None
    ship: Callable[[Settings, Array], ShipMotion] | None = None
    place: Callable[[Settings, Array], tuple[Array, Array]] | None = None


@dataclass(frozen=True, kw_only=True)
class KindFit:
    """The fit of derivatives to tests of one kind alone.

    `factors`: variables that may stand in the derivatives. `beside`: kinds of test that take
    part as well.
    """

    factors: tuple[str, ...]
    beside: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class TestKind:
    """A kind of test.

    Parameters
    ----------
    name, title : str
        Name in files, and name for people.
    family : {"steady", "oscillating", "free-running"}
        Captive with the motion held, captive with the model or its rudder swung, or free running.
    needs, takes : tuple of str
        Settings (names of `Settings`) without which such a test is not described; those that it
        may well have besides. Speed, revolutions and phase go without saying, and ``yaw_rate``
        stands for the radius too.
    varies : tuple of str
        What changes within a test or from one to the next: ``u, v, r, udot, vdot, rdot, phi,
        delta, rps``. Of a captive test all others but u and the revolutions are zero.
    swings : tuple of Swing
        What oscillates; the displacement of the first goes with sin θ.
    motion : NominalMotion
        How a captive test goes.
    told_by : tuple of PhaseChannel
        Channels that tell the phase, the best first; by default displacement and velocity of the
        first swing.
    fit : KindFit, optional
        Which derivatives tests of this kind tell by themselves; absent where they tell too little.
    quasi_steady : float
        ω' = ωL/U up to which the test counts as quasi-steady [-].
    propeller_stops : bool
        Whether a propeller at rest belongs to the test.
    of_standard : bool
        Whether the IMO judges ships by it (MSC.137(76)), and measures of its track are known.
    codes : tuple of str
        Usual abbreviations in names of runs and files, ours first.
    phrase : str
        Regular expression for what people call the test, in small letters.
    shares : mapping of str to tuple of float, optional
        Settings at which a plan offers the test, as shares of the largest that the rig allows;
        absent where no plan offers it.
    usual : bool
        Whether every planar motion mechanism can make it.
    at_rest : bool
        Whether the carriage stands: a check of the balance, of which nothing is reduced.

    Examples
    --------
    >>> from pmmkit.campaigns.test_kinds.kind import TEST_KINDS
    >>> kind = TEST_KINDS["yaw_drift"]
    >>> kind.title, kind.family, kind.needs
    ('yaw with drift', 'oscillating', ('period', 'yaw_amplitude', 'drift'))
    >>> kind.yaws, kind.sways, kind.drifts, TEST_KINDS["pure_yaw"].zero
    (True, False, True, ('v', 'vdot', 'phi', 'delta'))
    """

    __test__: ClassVar[bool] = False  # the name begins with Test, and pytest would collect it
    MAY_BE_ZERO: ClassVar[tuple[str, ...]] = ("v", "r", "udot", "vdot", "rdot", "phi", "delta")
    """Variables of the motion that some kinds of test keep at zero."""

    name: str
    title: str
    family: Family
    needs: tuple[str, ...] = ()
    takes: tuple[str, ...] = ()
    varies: tuple[str, ...] = ()
    swings: tuple[Swing, ...] = ()
    motion: NominalMotion = NominalMotion()
    told_by: tuple[PhaseChannel, ...] = ()
    fit: KindFit | None = None
    quasi_steady: float = math.inf
    propeller_stops: bool = False
    of_standard: bool = False
    codes: tuple[str, ...] = ()
    phrase: str = ""
    shares: Mapping[str, tuple[float, ...]] | None = None
    usual: bool = False
    at_rest: bool = False

    @property
    def captive(self) -> bool:
        """Whether the carriage prescribes the motion."""
        return self.family != "free-running"

    @property
    def free_running(self) -> bool:
        """Whether the motion is a result and not a setting."""
        return self.family == "free-running"

    @property
    def steady(self) -> bool:
        """Whether the model is held in a steady motion."""
        return self.family == "steady"

    @property
    def oscillates(self) -> bool:
        """Whether the model, or its rudder, is swung."""
        return self.family == "oscillating"

    @property
    def surges(self) -> bool:
        """Whether the surge motion oscillates by itself."""
        return SURGE in self.swings

    @property
    def sways(self) -> bool:
        """Whether the sway motion oscillates by itself."""
        return SWAY in self.swings

    @property
    def yaws(self) -> bool:
        """Whether the heading oscillates."""
        return YAW in self.swings

    @property
    def swings_rudder(self) -> bool:
        """Whether the rudder oscillates."""
        return RUDDER in self.swings

    @property
    def swings_hull(self) -> bool:
        """Whether the hull oscillates, and not the rudder alone."""
        return self.oscillates and self.swings != (RUDDER,)

    @property
    def drifts(self) -> bool:
        """Whether the test is one with a drift angle."""
        return "drift" in self.needs

    @property
    def heels(self) -> bool:
        """Whether the test is one with heel."""
        return "heel" in self.needs

    @property
    def turns_rudder(self) -> bool:
        """Whether the test is one with a rudder angle."""
        return "rudder" in self.needs

    @property
    def switches(self) -> bool:
        """Whether the heading decides when the rudder is put over."""
        return "switch" in self.needs

    @property
    def circles(self) -> bool:
        """Whether the model is held in a steady turn."""
        return "yaw_rate" in self.needs

    @property
    def straight(self) -> bool:
        """Whether the model is held on a straight course."""
        return self.steady and not self.circles

    @property
    def upright(self) -> bool:
        """Whether the model is held on a straight course without heel."""
        return self.straight and not self.heels

    @property
    def straight_ahead(self) -> bool:
        """Whether only speed and revolutions vary, so that nothing manoeuvres."""
        return self.steady and {"u", "rps"} >= set(self.varies)

    @property
    def measures_resistance(self) -> bool:
        """Whether nothing but the speed varies."""
        return self.steady and self.varies == ("u",)

    @property
    def held(self) -> tuple[str, ...]:
        """Settings that it needs besides those of an oscillation."""
        swung = {"period", *(swing.amplitude for swing in self.swings)}
        return tuple(name for name in self.needs if name not in swung)

    @property
    def zero(self) -> tuple[str, ...]:
        """Variables of the motion that are zero in it; of free-running tests none is."""
        return tuple(x for x in self.MAY_BE_ZERO if self.captive and x not in self.varies)

    @property
    def pure(self) -> str:
        """The velocity that oscillates, where it is alone and no angle is held; else empty."""
        return self.swings[0].velocity if len(self.swings) == 1 and not self.held else ""

    @property
    def leading(self) -> Swing | None:
        """The oscillation whose displacement goes with sin θ."""
        return self.swings[0] if self.swings else None

    @property
    def places(self) -> frozenset[str]:
        """Positions and heading that say what an oscillating test did, no setting needed."""
        return frozenset({"y", "psi", *(swing.displacement for swing in self.swings)})

    @property
    def phase_channels(self) -> tuple[PhaseChannel, ...]:
        """Channels that tell the phase, the best first."""
        if self.told_by or self.leading is None:
            return self.told_by
        return tuple(
            PhaseChannel(channel=name, with_cosine=rate, amplitude=self.leading.amplitude)
            for name, rate in ((self.leading.displacement, False), (self.leading.velocity, True))
            if name
        )

    @property
    def code(self) -> str:
        """Abbreviation in the names of planned runs."""
        return self.codes[0] if self.codes else self.name

    def nominal(self, settings: Settings, theta: Array) -> ShipMotion:
        """Motion in ship axes that a captive test is set to.

        Parameters
        ----------
        settings : Settings
            What it is set to.
        theta : array (n,)
            Phases θ [rad]; any for a steady test.

        Raises
        ------
        NotImplementedError
            If the kind has no nominal motion.
        """
        if self.motion.ship is not None and not self._on_struts(settings):
            return self.motion.ship(settings, theta)
        return self.in_tank(settings, theta).in_ship_axes

    def in_tank(self, settings: Settings, theta: Array) -> TankMotion:
        """Motion in tank axes that a captive test is set to, see `nominal`."""
        if self._on_struts(settings):
            found = swung(settings, self._phase_of_struts(theta), lags=self.sways)
            return TankMotion(**{each.name: found[each.name] for each in fields(TankMotion)})
        if self.motion.tank is None:
            raise NotImplementedError(f"{self.title} has no nominal motion in tank axes")
        return self.motion.tank(settings, theta)

    def place(self, settings: Settings, theta: Array) -> tuple[Array, Array] | None:
        """Where the hull is, x and y from rest [m]; None where the settings do not tell it.

        Parameters
        ----------
        settings, theta
            As for `nominal`; the axes move with the carriage.
        """
        if self._on_struts(settings):
            found = swung(settings, self._phase_of_struts(theta), lags=self.sways)
            return found["x"], found["y"]
        return None if self.motion.place is None else self.motion.place(settings, theta)

    def _on_struts(self, settings: Settings) -> bool:
        return settings.strut_spacing is not None and (self.sways or self.yaws)

    def _phase_of_struts(self, theta: Array) -> Array:
        """Phase θs of `swung`: with sway θ itself; alone the heading goes with sin θ = cos θs."""
        return theta if self.sways else theta - 0.5 * math.pi


# All kinds of test: those of this folder and those of installed packages.


GROUP: Final = "pmmkit.test_kinds"
"""Entry points by which other packages bring their kinds of test."""
TEST_KINDS: Final = Registry(
    TestKind,
    what="kind of test",
    listed="pmmkit.campaigns.test_kinds:KINDS",
    first=("steady", "oscillating", "check_load", "free_running"),
    group=GROUP,
    unknown="{name!r} is not one of {names}{guess}",
    contract="pmmkit.testing.test_kinds:check_test_kind",
)
"""All kinds of test by name: captive, free running, then those of other packages."""
