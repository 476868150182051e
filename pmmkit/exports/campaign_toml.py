"""The campaign file that reads an exported campaign back: settings, particulars, uncertainties."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from datetime import datetime
from typing import Any, Final

from pmmkit.base import CampaignError
from pmmkit.campaigns import RUN_SETTINGS, Campaign, Run, TypeB
from pmmkit.exports.text import written_by
from pmmkit.files import toml_text
from pmmkit.syntax import comment

_ZERO: Final = ("drift", "heel", "rudder", "phase")
"""Settings that are zero where nothing is stated, and are written first."""
_NEXT: Final = ("yaw_amplitude", "rudder_amplitude", "switch", "amplitude", "period")
"""Those that are written next; the others follow in the order of their keys."""
_SHIP: Final = {
    "name": "name",
    "L": "L",
    "B": "B",
    "d": "d",
    "volume": "volume",
    "mass": "mass",
    "Izz": "Izz",
    "xG": "xG",
    "zG": "zG",
    "GM": "GM",
    "Ixx": "Ix",
    "balance_mass": "balance_mass",
    "balance_Izz": "balance_Izz",
    "balance_xG": "balance_xG",
    "block_stated": "CB",
}
_WATER: Final = ("rho", "g", "nu", "depth", "tank_width", "tank_depth")


def campaign_text(campaign: Campaign, entries: Mapping[str, Mapping[str, Any]]) -> str:
    """The text of ``campaign.toml`` for runs whose data are SI, in ship axes, corrected."""
    every = [*campaign.runs, *(run for run, _ in campaign.excluded)]
    kept = [run for run in every if run.id in entries]
    data: dict[str, Any] = {
        "campaign": {
            "title": campaign.title,
            "kind": campaign.kind,
            "closed": True,
            "forces": campaign.forces,
            "moment_reference_x": campaign.moment_reference_x,
            "moment_reference_z": campaign.moment_reference_z,
            "motion_reference_x": campaign.motion_reference_x,
            "free": list(campaign.free),
        },
        "ship": _given({key: getattr(campaign.ship, name) for name, key in _SHIP.items()}),
        "water": _given({name: getattr(campaign.water, name) for name in _WATER}),
        "struts": _struts(campaign, kept),
        "cfd": _cfd(campaign),
        "propeller": campaign.propeller,
        "rudder": campaign.rudder,
        "trial": _trial(campaign),
        "imo": dict(campaign.imo),
        "report": campaign.report,
        "uncertainty": _uncertainty(campaign.uncertainty),
        "corrections": _corrections(campaign, kept),
        "runs": [
            {
                "id": run.id,
                "test": run.test,
                **({"started": datetime.fromisoformat(run.started)} if run.started else {}),
                **settings_of(run),
                **entries[run.id],
            }
            for run in kept
        ],
    }
    lines = [
        *written_by("#"),
        *comment(
            "Data are SI, in ship axes and signs of pmmkit; conversions and corrections of samples "
            "have been applied.",
            "#",
        ),
        *(
            line
            for key, value in campaign.provenance.items()
            for line in comment(f"Source, {key}: {value}", "#")
        ),
        *(line for told in _applied(kept) for line in comment(told, "#")),
        *(
            line
            for run, reason in campaign.excluded
            if run.id not in entries
            for line in comment(f"Run {run.id} is not here: {reason}; it cannot be read.", "#")
        ),
    ]
    data = {key: value for key, value in data.items() if value} | {"end": {}}
    try:
        text = toml_text({key: _listed(value) for key, value in data.items()})
    except TypeError as error:
        raise CampaignError(
            f"{error}.", remedy="Export the campaign as netcdf, which keeps it."
        ) from error
    return "\n".join(lines) + "\n\n" + text


def settings_of(run: Run) -> dict[str, Any]:
    """The settings of a run as a campaign file states them."""
    given, stated = run.settings, run.stated
    found: dict[str, Any] = {"speed": given.speed}
    for item in RUN_SETTINGS.ordered(*_ZERO, *_NEXT):
        value = given.value(item.name) if item.kept and item.name != "speed" else None
        key, zero = item.in_file, item.name in _ZERO
        if value is None or (
            zero and not (value or key in stated or (not stated and item.name != "phase"))
        ):
            continue
        found[key] = _before(item.to_si, value, item.to_file(value)) if item.angle else value
    if given.repeat_of is not None:
        found["repeat_of"] = given.repeat_of
    if given.strut_spacing is not None:
        for key in ("amplitude_m", "yaw_amplitude_deg"):
            found.pop(key, None)
        amplitude, lead = run.strut_swing
        found |= {"strut_amplitude_m": amplitude, "strut_phase_deg": math.degrees(lead)}
    return found


def _struts(campaign: Campaign, runs: list[Run]) -> dict[str, Any]:
    """``[struts]``, the same for all runs that state theirs."""
    found = [run.settings for run in runs if run.settings.strut_spacing is not None]
    if not found:
        return {}
    spacing = found[0].strut_spacing or 0.0
    return {
        "spacing": abs(spacing),
        "centre_x": found[0].strut_centre + campaign.motion_reference_x,
        "slides": "aft" if spacing > 0 else "forward",
    }


def _before(forward: Callable[[float], float], value: float, guess: float) -> float:
    """A number near a guess that becomes a value; the guess itself where there is none."""
    near = [round(guess, 12), guess]
    for toward in (math.inf, -math.inf):
        step = guess
        for _ in range(4):
            step = math.nextafter(step, toward)
            near.append(step)
    return next((item for item in near if forward(item) == value), guess)


def _applied(runs: list[Run]) -> list[str]:
    """Corrections that changed samples, each once."""
    every = (item for run in runs for item in run.corrections if item.changes_samples)
    return list(
        dict.fromkeys(
            f"Correction applied to {', '.join(item.runs)}: {item.action} ({item.reason})"
            for item in every
        )
    )


def _given(values: Mapping[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in values.items() if value is not None}


def _listed(value: Any) -> Any:
    """Tuples as lists, so that only what TOML knows is left."""
    if isinstance(value, Mapping):
        return {str(key): _listed(item) for key, item in value.items() if item is not None}
    return [_listed(item) for item in value] if isinstance(value, list | tuple) else value


def _cfd(campaign: Campaign) -> dict[str, Any]:
    """``[cfd]`` with nothing left to do: factors, axes and start-up have been applied."""
    done = {
        "rho_inf": campaign.water.rho,
        "symmetry_factor": 1.0,
        "forces_in": "body",
        "moment_centre_moves": True,
        "ramp_s": 0.0,
    }
    found = {key: done.get(key, value) for key, value in campaign.cfd.items() if key != "U_SN"}
    return found | ({"U_SN": dict(campaign.numerical)} if campaign.numerical else {})


def _trial(campaign: Campaign) -> dict[str, Any]:
    """``[trial]`` with the antenna at midship, to which the positions have been moved."""
    if campaign.kind == "captive":
        return {}
    return {
        key: value for key, value in campaign.trial.items() if key not in ("antenna_x", "antenna_y")
    }


def _uncertainty(stated: tuple[TypeB, ...]) -> dict[str, Any]:
    found: dict[str, list[dict[str, Any]]] = {}
    for item in stated:
        std: float = item.std
        if item.relative:
            std = _before(lambda percent: percent / 100, std, 100 * std)
        elif item.kind.unit == "deg":
            std = _before(lambda degrees: degrees * (math.pi / 180), std, math.degrees(std))
        unit = {"unit": "%"} if item.relative else {}
        cause = {"common": item.common} if item.common else {}
        entry = {"std": std, **unit, "shared": item.shared, **cause}
        found.setdefault(item.kind.key, []).append(entry)
    return {name: items[0] if len(items) == 1 else items for name, items in found.items()}


def _corrections(campaign: Campaign, kept: list[Run]) -> list[dict[str, Any]]:
    """What is said of runs and not done to their samples."""
    written = {run.id for run in kept}
    found = [
        {"runs": [run.id], "action": "exclude", "reason": reason or "left out"}
        for run, reason in campaign.excluded
        if run.id in written
    ]
    says = {"hydrodynamic": "inertia already removed", "balance": "inertia still inside"}
    for forces, action in says.items():
        other = [run.id for run in kept if run.forces == forces != campaign.forces]
        if other:
            reason = "as in the campaign that was exported"
            found.append({"runs": other, "action": action, "reason": reason})
    wrong = [run.id for run in kept if not run.use_means]
    if wrong:
        reason = "as in the campaign that was exported"
        found.append({"runs": wrong, "action": "drop means", "reason": reason})
    literal = [{**item, "runs": [_literal(name) for name in item["runs"]]} for item in found]
    accepted = {
        (item.runs, item.values["check"], item.reason): None
        for run in kept
        for item in run.corrections
        if item.action == "accept"
    }
    return literal + [
        {"runs": list(runs), "action": "accept", "check": check, "reason": reason}
        for runs, check, reason in accepted
    ]


def _literal(run_id: str) -> str:
    """An id as a pattern that means only itself."""
    return "".join(f"[{letter}]" if letter in "*?[" else letter for letter in run_id)
