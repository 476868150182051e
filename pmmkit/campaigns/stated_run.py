"""What is stated of a run, its data aside: what it was set to, and so how it should move."""

from __future__ import annotations

import fnmatch
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from types import MappingProxyType
from typing import Any, ClassVar, Final, Literal, Self

import numpy as np
from numpy.typing import ArrayLike

from pmmkit.base import CampaignError, Problem
from pmmkit.campaigns.settings import Settings
from pmmkit.campaigns.test_kinds.kind import TEST_KINDS, Struts, TestKind
from pmmkit.effects import State
from pmmkit.numerics import Array
from pmmkit.signals import FEWEST

Kind = Literal["history", "means", "harmonics"]
FORCES: Final = {
    "hydrodynamic": "those of the water on the hull",
    "balance": "readings of the balance, with the inertia of the model",
}


@dataclass(frozen=True, kw_only=True)
class Correction:
    """Something that was done to the data because the campaign file says so, and why.

    Parameters
    ----------
    runs : tuple of str
        Ids of runs, ``*`` and ``?`` allowed.
    action : str
        ``exclude``, ``scale``, ``shift``, ``flip``, ``trim``, ``window``, ``tare``,
        ``drop means``, ``drop``, ``inertia still inside``, ``inertia already removed``,
        ``accept`` (what a check says).
    reason : str
        Why, in the user's words.
    values : mapping
        What the action needs, e.g. ``{"channels": ["X"], "factor": 2.0}``.
    """

    runs: tuple[str, ...]
    action: str
    reason: str
    values: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))

    @property
    def changes_samples(self) -> bool:
        """Whether it changes the numbers of a run; the others change what is said of it."""
        return self.action in ("scale", "shift", "flip", "trim", "drop", "tare")

    def applies_to(self, run_id: str) -> bool:
        """Whether a run is meant."""
        return any(fnmatch.fnmatchcase(run_id, pattern) for pattern in self.runs)


@dataclass(frozen=True, kw_only=True, repr=False)
class StatedRun:
    """What is stated of a run; `Run` has its data too, and says what each entry is."""

    id: str
    test: str
    kind: Kind
    settings: Settings
    forces: Literal["hydrodynamic", "balance"] = "hydrodynamic"
    use_means: bool = True
    stated: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    corrections: tuple[Correction, ...] = ()
    source: str = ""
    started: str = ""
    FARTHEST: ClassVar[float] = math.radians(45.0)
    """Drift from which a steady run says nothing to polynomials about straight ahead: the
    programmes that these were made for end at 20 to 30°, harbour tests begin beyond."""
    FEWEST_A_CYCLE: ClassVar[int] = 4
    """Samples of a cycle: less do not tell its first harmonic from its mean and the second one."""
    LONGEST: ClassVar[float] = 10.0
    """Time from the first sample to the last, over what the samples fill at their usual step. Work
    and memory go with the time; a recorder that stops between cycles or turns is below 5."""

    @property
    def kind_of_test(self) -> TestKind:
        """What there is to know of tests such as this one."""
        return TEST_KINDS[self.test]

    @property
    def forces_in_words(self) -> str:
        """Whether the inertia of the model is inside the forces."""
        return FORCES[self.forces]

    @property
    def dynamic(self) -> bool:
        """Whether the model oscillates."""
        return self.kind_of_test.oscillates

    @property
    def setting(self) -> str:
        """What it was set to, with the speed, without the kind of test."""
        surges = self.kind_of_test.surges
        parts = [
            f"{'surge' if surges and told.symbol == 'a' else told.word} {value:.3g}{told.unit}"
            for told, value in self.settings.told
        ]
        return ", ".join([f"{self.settings.speed:.3g} m/s", *parts])

    @property
    def across_the_flow(self) -> bool:
        """Whether the hull was held at a drift angle that no polynomial reaches."""
        drift = abs(math.remainder(self.settings.drift, 2 * math.pi))
        return not self.kind_of_test.swings_hull and drift > self.FARTHEST

    @property
    def strut_swing(self) -> tuple[float, float]:
        """Amplitude of each of two struts [m] and lead of the forward one [rad]."""
        struts = Struts(spacing=abs(self.settings.strut_spacing or 0.0))
        return struts.amplitude_and_phase(self.settings, lags=self.kind_of_test.sways)

    @property
    def start(self) -> float | None:
        """When it started, in seconds of one clock, UTC where no zone is stated; None if unknown.

        Examples
        --------
        >>> run = StatedRun(id="a", test="resistance", kind="means", settings=Settings(speed=1.0))
        >>> early, late = (run.with_(started=f"2026-05-04T09:{x}:00") for x in ("00", "15"))
        >>> late.start - early.start, run.start
        (900.0, None)
        """
        if not self.started:
            return None
        instant = datetime.fromisoformat(self.started)
        return (instant if instant.tzinfo else instant.replace(tzinfo=UTC)).timestamp()

    def with_(self, **changes: Any) -> Self:
        """A copy with some entries changed."""
        return replace(self, **changes)

    def nominal_motion(self, times: ArrayLike) -> State:
        """Motion that a captive test was set to, exact in every angle.

        times [s].

        Examples
        --------
        >>> run = StatedRun(id="PY", test="pure_yaw", kind="history",
        ...                 settings=Settings(speed=1.5, period=10.0, yaw_amplitude=0.2))
        >>> state = run.nominal_motion([0.0, 2.5])
        >>> state.u.round(6), state.r.round(6)
        (array([1.5     , 1.530508]), array([0.125664, 0.      ]))
        """
        return self.motion_at_phase(self.nominal_phase(self.instants(times)))

    def motion_at_phase(self, theta: ArrayLike) -> State:
        """Nominal motion at phases θ (n,) of the displacement [rad]; any for a static test."""
        self.require_settings()
        phase = self.instants(theta)
        motion = self.kind_of_test.nominal(self.settings, phase)
        return State.of(len(phase), **{**self.beside_motion(phase), **motion})

    def beside_motion(self, theta: Array) -> dict[str, float | Array]:
        """Heel, rudder and revolutions of the test at phases θ, by their names in `State`."""
        settings, delta = self.settings, np.full_like(theta, self.settings.rudder)
        if self.kind_of_test.swings_rudder:
            delta += (settings.rudder_amplitude or 0.0) * np.sin(theta)
        return {"phi": settings.heel, "delta": delta, "rps": settings.propeller_rps or 0.0}

    def nominal_phase(self, times: Array) -> Array:
        """Phase ωt + phase of the displacement [rad], array (n,)."""
        return (self.settings.omega or 0.0) * times + self.settings.phase

    def instants(self, times: ArrayLike) -> Array:
        """Times (or phases) as an array (n,); a CampaignError where there are none."""
        found = np.atleast_1d(np.asarray(times, float))
        if found.ndim != 1 or found.size == 0:
            raise CampaignError("there are no times at all.", run=self.id)
        return found

    def clock_problem(self, times: Array) -> Problem | None:
        """What makes the times of a captive record unusable; None where nothing does.

        times (n,) [s].

        Examples
        --------
        >>> run = StatedRun(id="PS", test="pure_sway", kind="history",
        ...                 settings=Settings(speed=1.5, period=10.0))
        >>> times = np.arange(815) * 0.1
        >>> run.clock_problem(times) is None
        True
        >>> print(run.clock_problem(1000 * times).message)
        a cycle of 10 s has only 0.1 samples, at steps of 100 s.
        >>> print(run.clock_problem(np.append(times, 1e7)).message)
        the time jumps by 9999918.6 s, where the usual step is 0.1 s.
        """
        count, steps = times.size, np.diff(times)
        usual = float(np.median(steps)) if count > 1 else 0.0
        span = float(times[-1] - times[0]) if count else 0.0
        period = self.settings.period if self.dynamic else None
        lost, back = np.flatnonzero(~np.isfinite(times)), np.flatnonzero(steps <= 0)
        row, remedy = 0, 'Cut these rows, or state a correction with action = "trim".'
        if count < FEWEST:
            message = f"only {count} of at least {FEWEST} samples are in the record."
            remedy = "Look whether the file was cut off, or leave the run out."
        elif lost.size:
            message, row = f"{lost.size} of {count} samples have no time.", int(lost[0]) + 1
        elif back.size:
            message = f"the time does not increase at {back.size} of {count} samples."
            row = int(back[0]) + 2
            remedy = "Look for two records in one file, or for rows written twice or out of order."
        elif span > self.LONGEST * count * usual:
            step = int(np.argmax(steps))
            message = (
                f"the time jumps by {steps[step]:.8g} s, where the usual step is {usual:.4g} s."
            )
            row = step + 2
        elif period and period < self.FEWEST_A_CYCLE * usual:
            message = (
                f"a cycle of {period:.4g} s has only {period / usual:.2g} samples, at steps of "
                f"{usual:.4g} s."
            )
            remedy = (
                "Correct the period, or say under [columns] in which unit the times are: "
                't = { name = "their name", unit = "ms" }.'
            )
        else:
            return None
        return Problem(
            message=message,
            file=self.source or None,
            run=self.id,
            column="t",
            row=row or None,
            remedy=remedy,
        )

    @property
    def has_nominal(self) -> bool:
        """Whether the settings say the motion, whatever the record says.

        Examples
        --------
        >>> run = StatedRun(id="CM", test="circular_motion", kind="history",
        ...                 settings=Settings(speed=1.5, radius=20.0))
        >>> run.has_nominal, run.with_(settings=Settings(speed=1.5)).has_nominal
        (True, False)
        """
        kind = self.kind_of_test
        return not kind.free_running and not self._wrong_settings(kind.needs)

    def refuse_free_running(self) -> None:
        """Raise a CampaignError for a free-running test."""
        if self.kind_of_test.free_running:
            raise CampaignError(
                f"a {self.test} test is free running: its motion is a result, not a setting.",
                run=self.id,
            )

    def require_settings(self, needed: Sequence[str] | None = None) -> None:
        """Raise a CampaignError naming all settings that are missing or impossible."""
        if needed is None:
            self.refuse_free_running()
            needed = self.kind_of_test.needs
        if wrong := self._wrong_settings(needed):
            raise CampaignError([Problem(message=message, run=self.id) for message in wrong])

    def _wrong_settings(self, needed: Sequence[str]) -> list[str]:
        """What is missing or impossible among some settings, in words."""
        settings = self.settings
        wrong = [
            f"a {self.test} test needs the setting {name}."
            for name in needed
            if name != "yaw_rate" and settings.value(name) is None
        ]
        if (
            settings.period is not None
            and not 0 < settings.period < math.inf
            and "period" in needed
        ):
            wrong.append(f"the period must be positive, not {settings.period:g} s.")
        if "yaw_amplitude" in needed and abs(settings.yaw_amplitude or 0.0) >= math.pi / 2:
            wrong.append(
                f"the heading amplitude is {math.degrees(settings.yaw_amplitude or 0.0):g}°; it "
                f"must be below 90°."
            )
        if "yaw_rate" in needed and settings.yaw_rate is None and not settings.radius:
            wrong.append(f"a {self.test} test needs yaw_rate, or a radius that is not zero.")
        return wrong
