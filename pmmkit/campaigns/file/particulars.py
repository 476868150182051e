"""From the single tables of a campaign file to ship, water, uncertainties and corrections."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Any, Final

from pmmkit.base import DataError, PmmkitError, did_you_mean
from pmmkit.campaigns.campaign import Campaign
from pmmkit.campaigns.file.assembly import Setup
from pmmkit.campaigns.file.schema import CorrectionEntry, known_columns, read_entry, read_named
from pmmkit.campaigns.file.search import Search, names_in, with_curve
from pmmkit.campaigns.file.single_tables import (
    AxesEntry,
    CampaignEntry,
    CfdEntry,
    ColumnEntry,
    Faults,
    ImoEntry,
    ReportEntry,
    ShipEntry,
    SourceEntry,
    StrictTable,
    StrutsEntry,
    TrialEntry,
    UncertainEntry,
    WaterEntry,
)
from pmmkit.campaigns.samples.column_mapping import ColumnSpec
from pmmkit.campaigns.samples.conversions import Frame, Solver
from pmmkit.campaigns.samples.loading import shift_in_si
from pmmkit.campaigns.stated_run import Correction
from pmmkit.campaigns.test_kinds.kind import Struts
from pmmkit.campaigns.uncertainty import CENTRE_STD, Statable, TypeB
from pmmkit.conventions import CHANNEL_UNITS, Ship, Water, factor_to
from pmmkit.readers import Options

_NEUTRAL_SHIP: Final = Ship(name="", L=1.0, B=1.0, d=1.0, volume=1.0, mass=1.0, Izz=1.0)
"""Stands in where the particulars are wrong, so that all other problems are still found."""


def read_tables(
    raw: Mapping[str, Any], search: Search, out: Faults
) -> tuple[Campaign, Setup, Mapping[int, str]]:
    """All tables but those of runs; what is wrong is added to `out`."""

    def table(name: str, model: type[Any]) -> Any:
        found = read_entry(model, raw.get(name, {}), f"[{name}]", out)
        return model() if found is None else found

    head: CampaignEntry = table("campaign", CampaignEntry)
    cfd: CfdEntry = table("cfd", CfdEntry)
    water = _water(table("water", WaterEntry), head, raw, out)
    before = len(out.problems)
    ship_entry: ShipEntry = table("ship", ShipEntry)
    ship = _NEUTRAL_SHIP
    if "ship" in raw and len(out.problems) == before:
        ship = _ship(ship_entry, water, out) or ship
    source: SourceEntry = table("source", SourceEntry)
    if source.nondimensional and cfd.rho_inf is not None:
        out.report(
            "rho_inf is for forces per density; [source] says they are "
            f"non-dimensional ({source.nondimensional}).",
            "[cfd], key 'rho_inf'",
        )
    if "trial" in raw and head.kind == "captive":
        out.report(
            "is for sea trials; the campaign is captive.",
            "[trial]",
            remedy='Write kind = "free-running" under [campaign].',
        )
    corrections, labels = _corrections(raw, out)
    uncertainty = _uncertainty(raw, out)
    columns = _columns(raw, out)
    axes: AxesEntry = table("axes", AxesEntry)
    struts = read_entry(StrutsEntry, raw["struts"], "[struts]", out) if "struts" in raw else None
    centre_x = _moment_reference(head, cfd, out)
    stated = _given(cfd)
    propeller = _stated_part("propeller", raw, out)
    rudder = _stated_part("rudder", raw, out)
    trial = MappingProxyType(_given(table("trial", TrialEntry)))
    imo = _given(table("imo", ImoEntry))
    report = table("report", ReportEntry).model_dump(exclude_defaults=True)
    search = search.within(head.data_folder)
    search.remote.find_all(names_in(raw))
    turned = (("x", axes.x), ("y", axes.y), ("z", axes.z))
    setup = Setup(
        ship=ship,
        water=water,
        kind=head.kind,
        planned=head.planned,
        forces=head.forces,
        frame=Frame(
            reversed_axes="".join(axis for axis, given in turned if given.startswith("-")),
            rudder_to_port=head.rudder_positive == "port",
            drift_positive=head.drift_positive,
            symmetry_factor=stated.get("symmetry_factor", 1.0),
            density_factor=1.0 if cfd.rho_inf is None else water.rho / cfd.rho_inf,
        ),
        options=Options(**source.model_dump()),
        columns=columns,
        corrections=corrections,
        side_gauges=None
        if head.side_gauges_x is None
        else (head.side_gauges_x[0], head.side_gauges_x[1]),
        struts=None
        if struts is None
        else Struts(
            spacing=struts.spacing,
            centre_x=struts.centre_x,
            slides=struts.slides,
            motion_x=head.motion_reference_x,
        ),
        solver=Solver(
            axes=stated.get("forces_in", "body"),
            centre_moves=stated.get("moment_centre_moves", True),
            centre_x=centre_x,
            motion_x=head.motion_reference_x,
            ramp=stated.get("ramp_s", 0.0),
            stated=frozenset(stated),
        ),
        search=search,
        trial=trial,
    )
    campaign = Campaign(
        title=head.title,
        ship=ship,
        water=water,
        runs=(),
        kind=head.kind,
        forces=head.forces,
        moment_reference_x=centre_x,
        moment_reference_z=head.moment_reference_z,
        motion_reference_x=head.motion_reference_x,
        free=tuple(head.free),
        uncertainty=(*uncertainty, *_assumed(uncertainty, ship_entry, ship, head)),
        cfd=MappingProxyType(stated),
        propeller=MappingProxyType(with_curve(propeller, search, out)),
        rudder=MappingProxyType(rudder),
        numerical=MappingProxyType({} if cfd.U_SN is None else _given(cfd.U_SN)),
        trial=trial,
        imo=MappingProxyType(imo),
        report=MappingProxyType(report),
    )
    return campaign, setup, labels


def _given(entry: StrictTable) -> dict[str, Any]:
    return {name: value for name, value in entry.model_dump().items() if value is not None}


def _water(
    entry: WaterEntry, campaign: CampaignEntry, raw: Mapping[str, Any], out: Faults
) -> Water:
    stated = raw.get("water", {})
    if campaign.kind == "captive" and isinstance(stated, Mapping) and "rho" not in stated:
        out.report(
            "is missing.",
            "[water], key 'rho'",
            remedy="State the density of the tank's water [kg/m³].",
        )
    return Water(**_given(entry))


def _ship(entry: ShipEntry, water: Water, out: Faults) -> Ship | None:
    if entry.model_fields_set == {"name"}:
        from pmmkit.models import load_ship

        try:
            return load_ship(entry.name)
        except PmmkitError as error:
            out.report(
                str(error),
                "[ship], key 'name'",
                remedy="Or give the particulars in full: L, B, d, mass, volume, Izz.",
            )
            return None
    missing = [name for name in ("L", "B", "d", "Izz") if getattr(entry, name) is None]
    if entry.mass is None and entry.volume is None:
        missing.append("mass or volume")
    if missing:
        out.report(
            f"{', '.join(missing)} {'is' if len(missing) == 1 else 'are'} missing.",
            "[ship]",
            remedy="Give the particulars in full, or only the name of a ship of the library.",
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


def _moment_reference(campaign: CampaignEntry, cfd: CfdEntry, out: Faults) -> float:
    stated, centre = campaign.moment_reference_x, cfd.moment_centre
    if stated is not None and centre is not None and stated != centre:
        out.report(
            f"is {centre:g} m; moment_reference_x of [campaign] is {stated:g} m.",
            "[cfd], key 'moment_centre'",
            remedy="They mean the same: state one.",
        )
    return next((value for value in (stated, centre) if value is not None), 0.0)


def _columns(raw: Mapping[str, Any], out: Faults) -> dict[str, ColumnSpec]:
    found = read_named(ColumnEntry, raw.get("columns", {}), "[columns]", out)
    try:
        known_columns(found)
    except ValueError as error:
        out.report(f"{error}.", "[columns]")
    return {name: ColumnSpec(**column.model_dump()) for name, column in found.items()}


def _stated_part(name: str, raw: Mapping[str, Any], out: Faults) -> dict[str, Any]:
    """What is stated of the propeller or the rudder; what is wrong is added to `out`."""
    from pmmkit.models import SECTIONS

    if name not in raw:
        return {}
    table = raw[name]
    if not isinstance(table, Mapping):
        out.report("must be a table.", f"[{name}]")
        return {}
    for key, fault in SECTIONS[name].problems(table):
        out.report(fault, f"[{name}]" + (f", key {key!r}" if key else ""))
    return dict(table)


def _by_key(known: Iterable[Statable]) -> dict[str, Statable]:
    return {item.key: item for item in known}


def _uncertainty(raw: Mapping[str, Any], out: Faults) -> tuple[TypeB, ...]:
    table = raw.get("uncertainty", {})
    if not isinstance(table, Mapping):
        out.report("must be a table.", "[uncertainty]")
        return ()
    statable = TypeB.STATABLE.derived(_by_key)
    found: list[TypeB] = []
    for name, value in table.items():
        entry = f"[uncertainty], key {name!r}"
        if name not in statable:
            out.report(f"not known{did_you_mean(name, statable) or '.'}", entry)
            continue
        for item in value if isinstance(value, list) else [value]:
            number = isinstance(item, (int, float)) and not isinstance(item, bool)
            stated = read_entry(UncertainEntry, {"std": item} if number else item, entry, out)
            if stated is not None:
                found += _type_b(statable[name], stated, entry, out)
    return tuple(found)


def _type_b(known: Statable, stated: UncertainEntry, entry: str, out: Faults) -> list[TypeB]:
    shared = stated.shared
    if shared is None:
        shared = known.single or bool(stated.common)
    if stated.common and not shared:
        out.report("has a common cause, so all runs share it: take shared = false away.", entry)
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
            out.report(str(error), entry)
            return []
    if factor is None:
        out.report(f"is measured in {target}, not in {stated.unit!r}.", entry)
        return []
    radians = math.pi / 180 if target == "deg" else 1.0
    return [replace(found, std=stated.std * factor * radians)]


def _corrections(
    raw: Mapping[str, Any], out: Faults
) -> tuple[tuple[Correction, ...], dict[int, str]]:
    listed = raw.get("corrections", [])
    if not isinstance(listed, list):
        out.report("must be written in double brackets.", "[[corrections]]")
        return (), {}
    found: list[Correction] = []
    labels: dict[int, str] = {}
    for number, item in enumerate(listed, start=1):
        label = f"[[corrections]] #{number}"
        entry = read_entry(CorrectionEntry, item, label, out)
        if entry is None:
            continue
        values = _correction_values(entry, label, out)
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


def _correction_values(entry: CorrectionEntry, label: str, out: Faults) -> dict[str, Any]:
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
            out.report(str(error), f"{label}, key 'unit'")
    return values
