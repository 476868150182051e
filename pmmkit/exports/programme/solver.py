"""What a programme for a solver has alike: a mesh that is towed through water at rest.

The mesh has x forward, y to port and z up, its origin at the point whose motion is meant (midship,
unless the campaign says another) at the height of the water; forces are those along the axes that
stay, moments those about the place where the origin was at rest. That is what the force reports of
both solvers give as they come, so that nothing has to be told to move with the hull.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from pmmkit.base import DataError
from pmmkit.campaigns import Campaign, Frame
from pmmkit.diagnosis import Programme
from pmmkit.exports.programme.campaign_file import programme_text
from pmmkit.exports.programme.towed_path import TowedPath, is_towed, towed_path

MESH: Final = Frame(reversed_axes="yz", drift_positive="starboard-bow")
"""Axes of the mesh, seen from those of the ship."""
NO_DAY: Final = "   No run is made again as a reference: a solver gives the same on any day."
_TURNED: Final = {"yaw_rate": "r", "radius": "r"}
"""Settings of a circle, and the channel with whose sign they are stated."""


@dataclass(frozen=True, kw_only=True)
class TowingSolver:
    """What is written for a solver.

    `format`: reader of what comes back. `forces`, `motion`: where the forces of a run, and the
    table of its motion, are in its folder. `write_run`: writes that folder. `how_to`: what to do,
    in lines.
    """

    format: str
    forces: str
    motion: str
    write_run: Callable[[Path, TowedPath, Campaign], None]
    how_to: Callable[[Programme, Campaign], list[str]]


def towed_paths(programme: Programme, campaign: Campaign) -> dict[str, TowedPath]:
    """The path of each run.

    Raises
    ------
    DataError
        If a run cannot be made by moving the mesh as a whole.
    """
    other = [run.id for run in programme.runs if not is_towed(run.option.test)]
    if other:
        raise DataError(
            f"In {', '.join(other)} the rudder swings, or the hull not in its plane: the mesh as a "
            "whole cannot be moved so.",
            remedy="Leave out such tests (tests under [limits], or [[runs]]), or take --to csv.",
        )
    return {
        run.id: towed_path(run.option.test, run.settings, run.option.record, campaign.ship)
        for run in programme.runs
    }


def solver_campaign(
    programme: Programme,
    campaign: Campaign,
    paths: Mapping[str, TowedPath],
    solver: TowingSolver,
    files: Mapping[str, str],
    said: Sequence[str],
) -> str:
    """The campaign file that reads forces along axes that stay, with the path of each run.

    files: by run, where its forces are. said: comments.
    """
    entries = [
        {
            **_stated(run.entry, run.option.test, paths[run.id]),
            "file": files[run.id],
            "motion": f"runs/{run.id}/{solver.motion}",
            "cfd": {"ramp_s": paths[run.id].run_up},
        }
        for run in programme.runs
    ]
    known = Campaign(
        title=campaign.title,
        ship=campaign.ship,
        water=campaign.water,
        runs=(),
        moment_reference_x=campaign.motion_reference_x,
        motion_reference_x=campaign.motion_reference_x,
        propeller=campaign.propeller,
        rudder=campaign.rudder,
    )
    return programme_text(
        known,
        entries,
        said,
        {
            "campaign": {"drift_positive": "starboard-bow", "rudder_positive": "starboard"},
            "source": {"format": solver.format},
            "axes": {"y": "-y", "z": "-z"},
            "cfd": {"forces_in": "earth", "moment_centre_moves": False},
        },
    )


def origin_in_words(campaign: Campaign) -> str:
    """Where the origin of the mesh lies."""
    ahead = campaign.motion_reference_x
    if not ahead:
        return "midship, at the height of the water at rest"
    side = "forward of" if ahead > 0 else "abaft"
    return f"{abs(ahead):.4g} m {side} midship, at the height of the water at rest"


def held_in_words(programme: Programme) -> list[str]:
    """What of a run no motion of the mesh makes: rudder, heel, propeller."""
    found = []
    for run in programme.runs:
        settings = run.settings
        held = [
            f"{word} {value:g} {unit}"
            for word, value, unit in (
                ("rudder at", math.degrees(settings.rudder), "deg"),
                ("hull heeled by", math.degrees(settings.heel), "deg"),
                ("propeller at", settings.propeller_rps or 0.0, "1/s"),
            )
            if value
        ]
        if held:
            found.append(f"  {run.id}: {', '.join(held)}")
    if not found:
        return []
    return [
        "",
        "The motion of the mesh does not hold these; they are yours to build into the case",
        "(rudder positive where it turns the ship to starboard, heel where starboard goes down):",
        *found,
    ]


def _stated(entry: Mapping[str, Any], test: str, path: TowedPath) -> dict[str, Any]:
    """The settings of a run as they are stated in the axes of the mesh."""
    found = {
        key: MESH.sign(_TURNED[key]) * value if key in _TURNED else value
        for key, value in entry.items()
    }
    if "period" in entry:
        phase = path.lead + (math.pi if MESH.motion_sign(test) < 0 else 0.0)
        found["phase_deg"] = round(math.degrees(math.remainder(phase, 2 * math.pi)), 4)
    return found
