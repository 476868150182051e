"""A submission beside a measurement: two campaigns, run by run, as if the one were a prediction."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import DataError, PmmkitError
from pmmkit.campaigns import TEST_KINDS, Campaign, Run, TypeB
from pmmkit.conventions import Convention
from pmmkit.identification import evaluate_trials
from pmmkit.numerics import Array
from pmmkit.reduction import FLOOR, View
from pmmkit.validation.captive import CaptiveRun, measured_shares, observed
from pmmkit.validation.comparison import Comparison
from pmmkit.validation.free_running import ManoeuvreComparison
from pmmkit.validation.groups import groups_off
from pmmkit.validation.uncertainty import Share, scales, sources_of

# Turning circles, zigzags and stops of a submission beside the measured ones.


_FROUDE: Final = 0.05
"""Share by which Froude numbers of the same manoeuvre may differ: approaches are never alike."""
_ORDER: Final = math.radians(1.0)
"""Rudder and heading of execute may differ by this."""


def compare_trials(
    submission: Campaign, campaign: Campaign
) -> tuple[tuple[ManoeuvreComparison, ...], tuple[str, ...]]:
    """Free-running manoeuvres of one campaign beside those of another, the measurement."""
    found: list[ManoeuvreComparison] = []
    alone: list[str] = []
    notes: list[str] = []
    for run in campaign:
        if not run.kind_of_test.of_standard:
            continue
        other = _same_given(run, campaign, submission)
        if other is None:
            alone.append(run.id)
            continue
        try:
            (measured,) = evaluate_trials(campaign, runs=[run.id])
            (theirs,) = evaluate_trials(submission, runs=[other.id])
        except PmmkitError as error:
            notes.append(f"{run.id} is left out: {error}")
            continue
        there = theirs.resized(measured.L, measured.speed)
        found.append(ManoeuvreComparison(run=run, trial=measured, track=there))
    if not found:
        raise DataError(
            [
                f"No turning circle, zigzag or stop of {submission.title!r} has the orders of one "
                f"of {campaign.title!r}: nothing can be compared.",
                *notes,
            ]
        )
    if alone:
        notes.append(f"Without a counterpart in the submission: {', '.join(alone)}.")
    return tuple(found), tuple(notes)


def _same_given(run: Run, ours: Campaign, theirs: Campaign) -> Run | None:
    """The run of the submission with the same orders, nearest in speed, of the same id first."""
    Fn = ours.froude(run)
    near = [
        other
        for other in theirs
        if other.test == run.test
        and abs(theirs.froude(other) / Fn - 1.0) <= _FROUDE
        and all(abs(a - b) <= _ORDER for a, b in zip(_given(run), _given(other), strict=True))
    ]
    near.sort(key=lambda other: (other.id != run.id, abs(theirs.froude(other) / Fn - 1.0)))
    return next(iter(near), None)


def _given(run: Run) -> tuple[float, float]:
    """Rudder and heading of execute [rad], 0 where a test has none."""
    given = run.settings
    if not TEST_KINDS[run.test].turns_rudder:
        return 0.0, 0.0
    rudder = given.rudder
    switch = abs(rudder) if given.switch is None else abs(given.switch)
    return rudder, switch if TEST_KINDS[run.test].switches else 0.0


_SAME: Final = 0.01
"""Share by which speeds, frequencies and amplitudes of the same condition may differ."""
_ANGLE: Final = math.radians(0.1)
"""Angles may differ by this."""


def compare_submission(
    submission: Campaign, campaign: Campaign, *, floor: float = FLOOR
) -> Comparison:
    """A campaign beside another that is held to be the measurement.

    Parameters
    ----------
    submission : Campaign
        Tests of the same hull form, measured or computed, at any scale: what workshops call S.
    campaign : Campaign
        The measurement, D, of the same kind.
    floor : float
        As for `compare`, of captive tests.

    Returns
    -------
    Comparison
        Of captive runs that both have: of the same kind and condition (Froude number, drift,
        rudder, heel, ω', amplitudes, r'), and of the same id where several are. Forces are brought
        to the scale and the speed of the measurement as coefficients over ½ρL²U², without any other
        correction, and compared in the harmonics that both have. Of free running turning circles,
        zigzags and stops with the same orders: rudder and heading of execute within 1°, Froude
        number within 5 %; of several the run of the same id, or the nearest in speed. Lengths go
        over in ship lengths and times in ship lengths over the approach speed; angles as they are.

    Raises
    ------
    DataError
        If only one of them is free-running, or no run has a counterpart.

    Notes
    -----
    The validation uncertainty [1]_ is that of `compare` with the submission's own in the place of
    the model's: noise, scatter of repeats, gauges and U_SN. Uncertainties of settings, which act
    through a slope that nobody states here, are not in it. Manoeuvres of both sides are evaluated
    as `evaluate_trials` does; their uncertainty is that of both.

    References
    ----------
    .. [1] ASME V&V 20 (2009); ITTC 7.5-03-01-01.

    Examples
    --------
    >>> import xarray as xr
    >>> from pmmkit.campaigns import Settings
    >>> from pmmkit.conventions import Ship, Water
    >>> ship = Ship(name="m", L=4.0, B=1.0, d=0.25, volume=0.5, mass=500.0, Izz=500.0)
    >>> def towed(title, force):
    ...     run = Run(id="SD_8", test="static_drift", kind="means",
    ...               settings=Settings(speed=1.0, drift=0.14),
    ...               loader=lambda: xr.Dataset({"Y": force}))
    ...     return Campaign(title=title, ship=ship, water=Water(), runs=(run,))
    >>> found = compare_submission(towed("S", 84.0), towed("D", 80.0))
    >>> float(found.captive[0].error("Y")[0])
    4.0
    """
    if submission.kind != campaign.kind:
        captive, free = sorted((submission, campaign), key=lambda x: x.kind == "free-running")
        raise DataError(
            f"{captive.title!r} is captive and {free.title!r} is free-running: forces are compared "
            "with forces, manoeuvres with manoeuvres."
        )
    runs: tuple[CaptiveRun, ...] = ()
    manoeuvres: tuple[ManoeuvreComparison, ...] = ()
    if campaign.kind == "captive":
        runs, notes = _compare_runs(submission, campaign, floor)
    else:
        manoeuvres, notes = compare_trials(submission, campaign)
    return Comparison(
        model=submission.title,
        campaign=campaign.title,
        kind=campaign.kind,
        ship=campaign.ship,
        water=campaign.water,
        floor=floor,
        captive=runs,
        free=(),
        manoeuvres=manoeuvres,
        rig=campaign.rig,
        notes=notes,
        disagreements=groups_off(runs, campaign) if runs else (),
    )


def _compare_runs(
    submission: Campaign, campaign: Campaign, floor: float
) -> tuple[tuple[CaptiveRun, ...], tuple[str, ...]]:
    """Captive runs that both have, and what a reader must know."""
    theirs, ours = observed(submission), observed(campaign)
    scale = scales(ours)
    found: list[CaptiveRun] = []
    alone: list[str] = []
    for view in ours:
        other = _counterpart(view, campaign, submission, theirs)
        if other is None:
            alone.append(view.run.id)
            continue
        run = _beside(view, other, campaign, submission, scale, floor)
        if run.channels:
            found.append(run)
    if not found:
        raise DataError(
            f"No run of {submission.title!r} has kind and condition of one of "
            f"{campaign.title!r}: nothing can be compared."
        )
    return tuple(found), tuple(_notes(found, alone, submission, campaign))


def _unit(campaign: Campaign, channel: str, view: View) -> float:
    """½ρL²U² of a run, ½ρL³U² of moments."""
    return Convention(system="prime").force_unit(
        channel, ship=campaign.ship, water=campaign.water, U=view.speed
    )


def _condition(campaign: Campaign, run: Run) -> tuple[dict[str, float], dict[str, float]]:
    """What a run was set to without dimension: sizes, and angles [rad]."""
    given, ship = run.settings, campaign.ship
    turned = given.speed / given.radius if given.radius else (given.yaw_rate or 0.0)
    sizes = {
        "Fn": campaign.froude(run),
        "omega": ((given.omega or 0.0) if run.dynamic else 0.0) * ship.L / given.speed,
        "amplitude": (given.amplitude or 0.0) / ship.L,
        "yaw rate": turned * ship.L / given.speed,
    }
    angles = {name: getattr(given, name) for name in ("drift", "rudder", "heel")}
    return sizes, {
        **angles,
        "yaw": given.yaw_amplitude or 0.0,
        "rudder swing": given.rudder_amplitude or 0.0,
    }


def _doubts(campaign: Campaign, view: View) -> Mapping[str, Share]:
    """Standard uncertainties of a run's harmonics, from what is known without a model."""
    sources = [
        item for item in sources_of(campaign, repeated=bool(view.repeated)) if _acts_alone(item)
    ]
    return measured_shares(view, campaign, campaign.rig, sources, _still, view.force)


def _acts_alone(source: TypeB) -> bool:
    """Whether a stated uncertainty changes a force without a slope that only a model knows."""
    return source.kind.of != "setting" and source.name != "motion_reference_x"


def _still(*_: object) -> dict[str, Array]:
    """The prediction of nobody, which no source that acts alone asks for."""
    return {}


def _counterpart(
    view: View, campaign: Campaign, submission: Campaign, theirs: Sequence[View]
) -> View | None:
    """The run of the submission that a measured run is compared with."""
    sizes, angles = _condition(campaign, view.run)
    near = []
    for other in theirs:
        if other.run.test != view.run.test:
            continue
        other_sizes, other_angles = _condition(submission, other.run)
        if all(
            math.isclose(size, other_sizes[name], rel_tol=_SAME, abs_tol=1e-9)
            for name, size in sizes.items()
        ) and all(abs(angle - other_angles[name]) <= _ANGLE for name, angle in angles.items()):
            near.append(other)
    same = [other for other in near if other.run.id == view.run.id]
    return next(iter([*same, *near]), None)


def _beside(
    view: View,
    other: View,
    campaign: Campaign,
    submission: Campaign,
    scale: Mapping[str, float],
    floor: float,
) -> CaptiveRun:
    """A measured run with the submission's harmonics for its prediction."""
    channels = [name for name in view.force if name in other.force]
    cut = _cut(view, [label in other.labels for label in view.labels], channels)
    places = [other.labels.index(label) for label in cut.labels]
    factor = {
        name: _unit(campaign, name, view) / _unit(submission, name, other) for name in channels
    }
    predicted = {name: factor[name] * other.force[name][places] for name in channels}
    own, beside = _doubts(campaign, cut), _doubts(submission, other)
    submitted = {
        name: factor[name]
        * np.sqrt(np.sum([share[name][places] ** 2 for share in beside.values()], axis=0))
        for name in channels
    }
    least = {name: np.full(cut.rows, floor * scale[name] * cut.speed**2) for name in channels}
    basis = cut.basis if cut.kept is None else cut.basis[:, cut.kept]
    return CaptiveRun(
        view=cut,
        Fn=campaign.froude(view.run),
        predicted=predicted,
        history={name: basis @ x for name, x in predicted.items()},
        shares={**own, "model": submitted, "floor": least},
    )


def _cut(view: View, common: Sequence[bool], channels: Sequence[str]) -> View:
    """A view with the harmonics and channels that another has too."""
    rows: NDArray[np.bool_] = np.array(common)
    force = {name: view.force[name][rows] for name in channels}
    covariance = {name: view.covariance[name][np.ix_(rows, rows)] for name in channels}
    if rows.all():
        return replace(view, force=force, covariance=covariance)
    kept = np.full(view.rows, True) if view.kept is None else view.kept.copy()
    kept[np.flatnonzero(kept)[~rows]] = False
    return replace(
        view,
        force=force,
        covariance=covariance,
        projection=view.projection[rows],
        every=view.projection if view.every is None else view.every,
        kept=kept,
        labels=tuple(label for label, own in zip(view.labels, rows, strict=True) if own),
    )


def _notes(
    found: Sequence[CaptiveRun], alone: Sequence[str], submission: Campaign, campaign: Campaign
) -> list[str]:
    notes = [
        "Uncertainties of settings (speed, angles, periods) are not in U_V: only a model tells "
        "what they do to a force."
    ]
    if alone:
        notes.append(f"Without a counterpart in the submission: {', '.join(alone)}.")
    ratio = submission.ship.L / campaign.ship.L
    if not math.isclose(ratio, 1.0, rel_tol=1e-3):
        notes.append(
            f"The submission's model is {ratio:.4g} times as long: its coefficients are compared "
            "as they are, without correction of friction or wake."
        )
    unknown = sorted(
        {name for item in found for name in item.channels if not item.view.known(name)}
    )
    if unknown:
        notes.append(
            f"Nothing is known of the noise of {', '.join(unknown)} in the measurement's tables: "
            "U_V holds only the floor and what else is named."
        )
    return notes
