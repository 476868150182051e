"""Turning circles in a report: the measures, the IMO limits, the change with speed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.base import PmmkitError, SimulationError
from pmmkit.conventions import METRICS, Criterion, Metric
from pmmkit.imo import Verdict, imo_turning
from pmmkit.models import Model, ReferenceTable
from pmmkit.plotting import manoeuvre
from pmmkit.presentation import Grid, Group, Section, fixed, number, percent
from pmmkit.simulation import froude_sweep, measures_over_froude, simulate
from pmmkit.views.figures.captions import drawn

if TYPE_CHECKING:
    import xarray as xr

    from pmmkit.simulation import Track

STEPS: Final = 7
"""Froude numbers of a sweep."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Turns:
    """Turning circles for a report.

    Parameters
    ----------
    tracks : sequence of Track
        Turns with the model that was found, one per speed.
    sweeps : mapping of str to Dataset
        Measures over the Froude number, ours first, as `froude_sweep` gives them.
    notes : sequence of str
        Notes of the model.
    failed : sequence of str
        Why there is none at a speed, or no sweep.
    """

    tracks: Sequence[Track]
    sweeps: Mapping[str, xr.Dataset] = field(default_factory=dict)
    notes: Sequence[str] = ()
    failed: Sequence[str] = ()

    @classmethod
    def of(
        cls, model: Model, tested: Sequence[float], reference: ReferenceTable | None = None
    ) -> Turns:
        """Turning circles at the speeds of the tests, and sweeps between them.

        tested: Froude numbers, where the model has one set of values for all. The reference sails
        beside it if it can.

        Raises
        ------
        SimulationError
            If the model cannot be sailed at any of the speeds.
        """
        tracks: list[Track] = []
        failed: list[str] = []
        for Fn in model.Fn or tuple(tested):
            try:
                speed = model.ship.speed(Fn, model.water.g)
                tracks.append(simulate(model, rudder_deg=Criterion.HARD_OVER, speed=speed))
            except PmmkitError as error:
                failed.append(str(error))
        if not tracks:
            raise SimulationError(failed[0])
        at = [track.Fn for track in tracks]
        along = np.linspace(at[0], at[-1], STEPS if len(at) > 1 else 1).tolist()
        sailing = {"these derivatives": model}
        if reference is not None and reference.model is not None:
            sailing[reference.name] = reference.model
        sweeps = {}
        for name, item in sailing.items():
            try:
                sweeps[name] = froude_sweep(item, Fn=along, rudder_deg=Criterion.HARD_OVER)
            except PmmkitError as error:
                failed.append(f"{name}: {error}")
        return cls(tracks=tracks, sweeps=sweeps, notes=model.notes, failed=failed)

    @property
    def changes(self) -> dict[str, float]:
        """Change of the measures from the lowest to the highest Froude number, as a share."""
        if len(self.tracks) < 2:
            return {}
        ordered = sorted(self.tracks, key=lambda item: item.Fn)
        first, last = ordered[0].metrics, ordered[-1].metrics
        return {name: last[name] / first[name] - 1 for name in reversed(ordered[0].circle)}


def _told(turns: Turns) -> list[str]:
    """The measures of each turn in a sentence."""
    sentences = []
    for track in turns.tracks:
        known = [
            f"{name.removesuffix('_L').replace('_', ' ')} {fixed(track.metrics[name], 2)} L"
            for name in ("advance_L", "transfer_L", "tactical_diameter_L")
            if np.isfinite(track.metrics.get(name, np.nan))
        ]
        if known:
            sentences.append(f"At Fn {track.Fn:.3f}: {', '.join(known)}.")
    return sentences


def turning_section(turns: Turns) -> Section:
    """The section on turning circles."""
    first = turns.tracks[0]
    fastest = max(turns.tracks, key=lambda track: track.speed)
    conditions = dict.fromkeys(text for item in imo_turning(fastest) for text in item.conditions)
    paragraphs = [
        f"Turning circles with {abs(first.rudder_deg):g}° of rudder. Scale: {first.scale}. Advance "
        "and transfer are counted from the rudder order to 90° of heading, the tactical diameter "
        "at 180°, all for the midship point.",
        "The limits are those of IMO MSC.137(76). What the standard asks for and these turns do "
        "not show, and what was assumed:",
    ]
    notes = dict.fromkeys(
        [
            *turns.failed,
            *turns.notes,
            *(text for track in turns.tracks for text in (*track.notes, *track.standing.sentences)),
        ]
    )
    shown = manoeuvre(turns.tracks, "turning circle")
    pictures = [
        drawn(
            shown["trajectory"],
            "Paths of midship in ship lengths. Filled marks: 90° of heading (advance, "
            "transfer); open marks: 180° (tactical diameter).",
            facts=_told(turns),
            narrow=True,
            file="trajectories",
        ),
        drawn(
            shown["histories"],
            "Speed, yaw rate, drift, heading, rudder and revolutions in the turn.",
        ),
    ]
    if any(sweep.sizes["Fn"] > 1 for sweep in turns.sweeps.values()):
        pictures.append(
            drawn(
                measures_over_froude(turns.sweeps),
                "Measures of the turning circle over the Froude number of the approach.",
            )
        )
    return Section(
        title="Turning circles",
        paragraphs=paragraphs,
        points=list(conditions | notes),
        tables=[_measures(turns)],
        figures=pictures,
    )


def _measures(turns: Turns) -> Grid:
    tracks = sorted(turns.tracks, key=lambda item: item.Fn)
    limits = _verdicts(tracks)
    names = METRICS.told("turn", tracks[0].metrics)
    moved = turns.changes
    rows: list[list[str | None]] = []
    for name in names:
        row: list[str | None] = [_titled(name), *(number(track.metrics[name]) for track in tracks)]
        if moved:
            row.append(percent(moved[name]) if name in moved else "")
        rows.append([*row, limits.get(name, "")])
    head = ["", *(f"Fn {track.Fn:.3f} ({track.speed:.3g} m/s)" for track in tracks)]
    return Grid(
        head=[*head, *(["change"] if moved else []), "IMO limit"], groups=[Group(rows=rows)]
    )


def _titled(name: str) -> str:
    """Long name of a number, with its unit."""
    title, unit = Metric.of(name).title.capitalize(), Metric.of(name).unit_of(name)
    return title if unit == "-" else f"{title} / L" if unit == "L" else f"{title} [{unit}]"


def _verdicts(tracks: Sequence[Track]) -> dict[str, str]:
    """Each limit, and at which speeds it is exceeded or not reached."""
    found: dict[str, str] = {}
    for same in zip(*(imo_turning(track) for track in tracks), strict=True):
        exceeded = [
            f"Fn {track.Fn:.3f}"
            for track, item in zip(tracks, same, strict=True)
            if item.passed is False
        ]
        text = f"{same[0].limit:g}"
        if exceeded:
            text += f", exceeded at {', '.join(exceeded)}"
        elif all(item.passed for item in same):
            text += ", met"
        elif not all(item.settled for item in same):
            text += f", {Verdict.UNSETTLED}"
        found[same[0].metric] = text
    return found
