"""From the single tables of a campaign file to ship, water, uncertainties and corrections."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, Final

from pmmkit.base import DataError, PmmkitError, Problem
from pmmkit.campaigns.file.assembly import Setup
from pmmkit.campaigns.file.report_entry import ReportEntry
from pmmkit.campaigns.file.schema import CorrectionEntry, known_columns, read_entry, read_named
from pmmkit.campaigns.file.single_tables import (
    AxesEntry,
    CampaignEntry,
    CfdEntry,
    ColumnEntry,
    ImoEntry,
    ShipEntry,
    SourceEntry,
    StrictTable,
    StrutsEntry,
    TrialEntry,
    UncertainEntry,
    WaterEntry,
)
from pmmkit.campaigns.motion.solver_axes import Solver
from pmmkit.campaigns.run import Correction
from pmmkit.campaigns.samples.column_mapping import ColumnSpec
from pmmkit.campaigns.samples.conversions import Frame
from pmmkit.campaigns.samples.corrections import shift_in_si
from pmmkit.campaigns.test_kinds.struts import Struts
from pmmkit.campaigns.uncertainty import CENTRE_STD, STATABLE, Statable, TypeB
from pmmkit.conventions import CHANNEL_UNITS, Ship, Water, did_you_mean, factor_to
from pmmkit.readers import Options, Request

_NEUTRAL_SHIP: Final = Ship(name="", L=1.0, B=1.0, d=1.0, volume=1.0, mass=1.0, Izz=1.0)
"""Stands in where the particulars are wrong, so that all other problems are still found."""

_STATABLE: Final = {item.key: item for item in STATABLE.values()}
"""By key under ``[uncertainty]``."""


@dataclass(frozen=True, kw_only=True)
class Top:
    """The single tables of a campaign file, validated."""

    campaign: CampaignEntry
    ship: Ship
    water: Water
    source: SourceEntry
    columns: Mapping[str, ColumnSpec]
    axes: AxesEntry
    struts: StrutsEntry | None
    moment_reference_x: float
    cfd: dict[str, Any]
    numerical: dict[str, float]
    propeller: dict[str, Any]
    rudder: dict[str, Any]
    trial: dict[str, Any]
    imo: dict[str, Any]
    report: dict[str, Any]
    uncertainty: tuple[TypeB, ...]
    corrections: tuple[Correction, ...]
    correction_labels: Mapping[int, str]


def read_top(raw: Mapping[str, Any], toml: str, problems: list[Problem]) -> Top:
    """All tables except runs and tables; what is wrong is added to `problems`."""

    def table(name: str, model: type[Any]) -> Any:
        found = read_entry(
            model, raw.get(name, {}), file=toml, entry=f"[{name}]", problems=problems
        )
        return model() if found is None else found

    campaign: CampaignEntry = table("campaign", CampaignEntry)
    cfd: CfdEntry = table("cfd", CfdEntry)
    water = _water(table("water", WaterEntry), campaign, raw, toml, problems)
    before = len(problems)
    ship_entry: ShipEntry = table("ship", ShipEntry)
    ship = _NEUTRAL_SHIP
    if "ship" in raw and len(problems) == before:
        ship = _ship(ship_entry, water, toml, problems) or ship
    source: SourceEntry = table("source", SourceEntry)
    if source.nondimensional and cfd.rho_inf is not None:
        problems.append(
            Problem(
                message="rho_inf is for forces per density; [source] says they are "
                f"non-dimensional ({source.nondimensional}).",
                file=toml,
                entry="[cfd], key 'rho_inf'",
            )
        )
    if "trial" in raw and campaign.kind == "captive":
        problems.append(
            Problem(
                message="is for sea trials; the campaign is captive.",
                file=toml,
                entry="[trial]",
                remedy='Write kind = "free-running" under [campaign].',
            )
        )
    corrections, labels = _corrections(raw, toml, problems)
    uncertainty = _uncertainty(raw, toml, problems)
    return Top(
        campaign=campaign,
        ship=ship,
        water=water,
        source=source,
        columns=_columns(raw, toml, problems),
        axes=table("axes", AxesEntry),
        struts=read_entry(
            StrutsEntry, raw["struts"], file=toml, entry="[struts]", problems=problems
        )
        if "struts" in raw
        else None,
        moment_reference_x=_moment_reference(campaign, cfd, toml, problems),
        cfd=_given(cfd),
        numerical={} if cfd.U_SN is None else _given(cfd.U_SN),
        propeller=_stated_part("propeller", raw, toml, problems),
        rudder=_stated_part("rudder", raw, toml, problems),
        trial=_given(table("trial", TrialEntry)),
        imo=_given(table("imo", ImoEntry)),
        report=table("report", ReportEntry).model_dump(exclude_defaults=True),
        uncertainty=(*uncertainty, *_assumed(uncertainty, ship_entry, ship, campaign)),
        corrections=corrections,
        correction_labels=labels,
    )


def setup_of(
    top: Top,
    *,
    find: Callable[[str], Request | None],
    missing_file: Callable[[str, str], Problem],
    toml: str,
) -> Setup:
    """What the runs need to know of the campaign."""
    axes = (("x", top.axes.x), ("y", top.axes.y), ("z", top.axes.z))
    reversed_axes = "".join(axis for axis, stated in axes if stated.startswith("-"))
    rho_inf = top.cfd.get("rho_inf")
    return Setup(
        ship=top.ship,
        water=top.water,
        kind=top.campaign.kind,
        forces=top.campaign.forces,
        frame=Frame(
            reversed_axes=reversed_axes,
            rudder_to_port=top.campaign.rudder_positive == "port",
            drift_positive=top.campaign.drift_positive,
            symmetry_factor=top.cfd.get("symmetry_factor", 1.0),
            density_factor=1.0 if rho_inf is None else top.water.rho / rho_inf,
        ),
        options=Options(**top.source.model_dump()),
        columns=top.columns,
        corrections=top.corrections,
        struts=None
        if top.struts is None
        else Struts(
            spacing=top.struts.spacing,
            centre_x=top.struts.centre_x,
            slides=top.struts.slides,
            motion_x=top.campaign.motion_reference_x,
        ),
        solver=Solver(
            axes=top.cfd.get("forces_in", "body"),
            centre_moves=top.cfd.get("moment_centre_moves", True),
            centre_x=top.moment_reference_x,
            motion_x=top.campaign.motion_reference_x,
            ramp=top.cfd.get("ramp_s", 0.0),
            stated=frozenset(top.cfd),
        ),
        find=find,
        missing_file=missing_file,
        toml=toml,
        trial=MappingProxyType(top.trial),
    )


def _given(entry: StrictTable) -> dict[str, Any]:
    return {name: value for name, value in entry.model_dump().items() if value is not None}


def _water(
    entry: WaterEntry,
    campaign: CampaignEntry,
    raw: Mapping[str, Any],
    toml: str,
    problems: list[Problem],
) -> Water:
    stated = raw.get("water", {})
    if campaign.kind == "captive" and isinstance(stated, Mapping) and "rho" not in stated:
        problems.append(
            Problem(
                message="is missing.",
                file=toml,
                entry="[water], key 'rho'",
                remedy="State the density of the tank's water [kg/m³].",
            )
        )
    return Water(**_given(entry))


def _ship(entry: ShipEntry, water: Water, toml: str, problems: list[Problem]) -> Ship | None:
    if entry.model_fields_set == {"name"}:
        from pmmkit.models import load_ship

        try:
            return load_ship(entry.name)
        except PmmkitError as error:
            problems.append(
                Problem(
                    message=str(error),
                    file=toml,
                    entry="[ship], key 'name'",
                    remedy="Or give the particulars in full: L, B, d, mass, volume, Izz.",
                )
            )
            return None
    missing = [name for name in ("L", "B", "d", "Izz") if getattr(entry, name) is None]
    if entry.mass is None and entry.volume is None:
        missing.append("mass or volume")
    if missing:
        problems.append(
            Problem(
                message=f"{', '.join(missing)} {'is' if len(missing) == 1 else 'are'} missing.",
                file=toml,
                entry="[ship]",
                remedy="Give the particulars in full, or only the name of a ship of the library.",
            )
        )
        return None
    volume = entry.volume if entry.volume is not None else (entry.mass or 0.0) / water.rho
    mass = entry.mass if entry.mass is not None else water.rho * volume
    balance_Izz = entry.balance_Izz
    centre = entry.xG or 0.0
    shift = balance_shift = 0.0
    if entry.Izz_about == "centre of gravity":
        shift = mass * centre**2
        arm = centre if entry.balance_xG is None else entry.balance_xG
        balance_shift = (mass if entry.balance_mass is None else entry.balance_mass) * arm**2
    return Ship(
        name=entry.name or "ship",
        L=entry.L or math.nan,
        B=entry.B or math.nan,
        d=entry.d or math.nan,
        volume=volume,
        mass=mass,
        Izz=(entry.Izz or math.nan) + shift,
        xG=centre,
        zG=entry.zG,
        GM=entry.GM,
        Ixx=entry.Ix,
        balance_mass=entry.balance_mass,
        balance_Izz=None if balance_Izz is None else balance_Izz + balance_shift,
        balance_xG=entry.balance_xG,
        block_stated=entry.CB,
    )


def _assumed(
    stated: Sequence[TypeB], entry: ShipEntry, ship: Ship, campaign: CampaignEntry
) -> list[TypeB]:
    """The uncertainty of a centre of gravity that nobody states and a balance's forces hold."""
    known = entry.model_fields_set == {"name"} or entry.balance_xG is not None
    if known or entry.xG is not None or campaign.forces != "balance":
        return []
    if any(item.name == "xG" for item in stated):
        return []
    return [TypeB(name="xG", std=CENTRE_STD * ship.L, shared=True, assumed=True)]


def _moment_reference(
    campaign: CampaignEntry, cfd: CfdEntry, toml: str, problems: list[Problem]
) -> float:
    stated, centre = campaign.moment_reference_x, cfd.moment_centre
    if stated is not None and centre is not None and stated != centre:
        problems.append(
            Problem(
                message=f"is {centre:g} m; moment_reference_x of [campaign] is {stated:g} m.",
                file=toml,
                entry="[cfd], key 'moment_centre'",
                remedy="They mean the same: state one.",
            )
        )
    return next((value for value in (stated, centre) if value is not None), 0.0)


def _columns(raw: Mapping[str, Any], toml: str, problems: list[Problem]) -> dict[str, ColumnSpec]:
    found = read_named(
        ColumnEntry, raw.get("columns", {}), file=toml, entry="[columns]", problems=problems
    )
    try:
        known_columns(found)
    except ValueError as error:
        problems.append(Problem(message=f"{error}.", file=toml, entry="[columns]"))
    return {name: ColumnSpec(**column.model_dump()) for name, column in found.items()}


def _stated_part(
    name: str, raw: Mapping[str, Any], toml: str, problems: list[Problem]
) -> dict[str, Any]:
    """What is stated of the propeller or the rudder; what is wrong is added to `problems`."""
    from pmmkit.models import problems_of

    if name not in raw:
        return {}
    table = raw[name]
    if not isinstance(table, Mapping):
        problems.append(Problem(message="must be a table.", file=toml, entry=f"[{name}]"))
        return {}
    problems += [
        Problem(message=fault, file=toml, entry=f"[{name}]" + (f", key {key!r}" if key else ""))
        for key, fault in problems_of(name, table)
    ]
    return dict(table)


def _uncertainty(raw: Mapping[str, Any], toml: str, problems: list[Problem]) -> tuple[TypeB, ...]:
    table = raw.get("uncertainty", {})
    if not isinstance(table, Mapping):
        problems.append(Problem(message="must be a table.", file=toml, entry="[uncertainty]"))
        return ()
    found: list[TypeB] = []
    for name, value in table.items():
        entry = f"[uncertainty], key {name!r}"
        if name not in _STATABLE:
            problems.append(
                Problem(
                    message=f"not known{did_you_mean(name, _STATABLE) or '.'}",
                    file=toml,
                    entry=entry,
                )
            )
            continue
        for item in value if isinstance(value, list) else [value]:
            number = isinstance(item, (int, float)) and not isinstance(item, bool)
            stated = read_entry(
                UncertainEntry,
                {"std": item} if number else item,
                file=toml,
                entry=entry,
                problems=problems,
            )
            if stated is not None:
                found += _type_b(_STATABLE[name], stated, entry, toml, problems)
    return tuple(found)


def _type_b(
    known: Statable, stated: UncertainEntry, entry: str, toml: str, problems: list[Problem]
) -> list[TypeB]:
    shared = stated.shared
    if shared is None:
        shared = known.single or bool(stated.common)
    if stated.common and not shared:
        message = "has a common cause, so all runs share it: take shared = false away."
        problems.append(Problem(message=message, file=toml, entry=entry))
        return []
    found = TypeB(name=known.name, std=stated.std, shared=shared, common=stated.common)
    if stated.unit == "%":
        return [replace(found, std=stated.std / 100, relative=True)]
    target = known.unit
    factor: float | None = 1.0
    if stated.unit not in (None, target):
        try:
            factor = factor_to(str(stated.unit), target)
        except DataError as error:
            problems.append(Problem(message=str(error), file=toml, entry=entry))
            return []
    if factor is None:
        problems.append(
            Problem(
                message=f"is measured in {target}, not in {stated.unit!r}.", file=toml, entry=entry
            )
        )
        return []
    radians = math.pi / 180 if target == "deg" else 1.0
    return [replace(found, std=stated.std * factor * radians)]


def _corrections(
    raw: Mapping[str, Any], toml: str, problems: list[Problem]
) -> tuple[tuple[Correction, ...], dict[int, str]]:
    listed = raw.get("corrections", [])
    if not isinstance(listed, list):
        problems.append(
            Problem(
                message="must be written in double brackets.", file=toml, entry="[[corrections]]"
            )
        )
        return (), {}
    found: list[Correction] = []
    labels: dict[int, str] = {}
    for number, item in enumerate(listed, start=1):
        label = f"[[corrections]] #{number}"
        entry = read_entry(CorrectionEntry, item, file=toml, entry=label, problems=problems)
        if entry is None:
            continue
        values = _correction_values(entry, label, toml, problems)
        labels[len(found)] = label
        found.append(
            Correction(
                runs=tuple(entry.runs),
                action=entry.action,
                reason=entry.reason,
                values=MappingProxyType(values),
            )
        )
    return tuple(found), labels


def _correction_values(
    entry: CorrectionEntry, label: str, toml: str, problems: list[Problem]
) -> dict[str, Any]:
    if entry.action == "set":
        return entry.settings()
    values: dict[str, Any] = {"channels": list(entry.channels)} if entry.channels else {}
    for name in ("factor", "t_start", "t_end", "check"):
        if getattr(entry, name) is not None:
            values[name] = getattr(entry, name)
    for channel in entry.channels if entry.value is not None else ():
        try:
            shifted = shift_in_si(channel, entry.value or 0.0, entry.unit)
            if shifted is None:
                raise DataError(
                    f"{channel} is measured in {CHANNEL_UNITS[channel]}, not in {entry.unit!r}."
                )
            values["value"] = shifted
        except DataError as error:
            problems.append(Problem(message=str(error), file=toml, entry=f"{label}, key 'unit'"))
    return values
