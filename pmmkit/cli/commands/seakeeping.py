"""``pmmkit seakeeping``."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from pmmkit.cli.motion_records import RecordFiles, RecordScale, beside_records, read_records
from pmmkit.cli.options import DrawFigures, numbers, stem
from pmmkit.cli.output import Outcome
from pmmkit.cli.outputs import Out, results_folder
from pmmkit.cli.ship_in_waves import damped, state_of_code, typed_hull, typed_place, typed_speeds

if TYPE_CHECKING:
    from pmmkit.models import Part
    from pmmkit.seakeeping import AddedResistance, Operability, Rao, Response, Sea

_FINE: Final = 120
"""Frequencies beside records, between which motions lie on straight lines."""
EXAMPLE: Final = (
    "pmmkit seakeeping tanker-320 --speeds '15.5 kn' --headings 180,135 --hs 4 --tp 9.7"
)


def seakeeping(
    ship: Annotated[
        str,
        typer.Argument(
            help="Offsets (.csv with x,y,z or x,breadth,draught,area; .mgf of ShipX), particulars "
            "(.toml), tanker-320, or a library ship; sections of the last three are assumed."
        ),
    ],
    speeds: Annotated[
        str, typer.Option(help="Speeds such as '10,15.5 kn', '8' [m/s] or 'Fn 0.2'.")
    ] = "0",
    headings: Annotated[
        str, typer.Option(help="Headings in degrees: 180 is head sea, 0 following.")
    ] = "180",
    draught: Annotated[
        float | None, typer.Option(help="Draught of a hull from a file [m].")
    ] = None,
    length: Annotated[
        float | None, typer.Option(help="Length between perpendiculars of a CSV [m].")
    ] = None,
    gm: Annotated[float | None, typer.Option(help="Metacentric height [m].")] = None,
    gyration: Annotated[
        str | None, typer.Option(help="Radii of gyration roll,pitch,yaw [m].")
    ] = None,
    roll_damping: Annotated[
        float | None, typer.Option(help="Over critical, beside that of waves; 0.05 if absent.")
    ] = None,
    bilge_keels: Annotated[
        str | None,
        typer.Option(
            help="Breadth,length of a bilge keel [m], 0,0 for none: roll damping by Ikeda's "
            "formulas, in the sea and at the one speed that are given."
        ),
    ] = None,
    omega: Annotated[
        str | None,
        typer.Option(
            help="Frequencies of the waves [rad/s]; if absent 40 from 5 L on, 120 with --record."
        ),
    ] = None,
    spectrum: Annotated[
        str, typer.Option(help="bretschneider, ittc, jonswap or pierson_moskowitz.")
    ] = "bretschneider",
    hs: Annotated[float | None, typer.Option(help="Significant wave height [m].")] = None,
    tp: Annotated[float | None, typer.Option(help="Peak period [s].")] = None,
    t1: Annotated[float | None, typer.Option(help="Mean period [s], in place of --tp.")] = None,
    gamma: Annotated[
        float | None, typer.Option(help="Peakedness of a jonswap; 3.3 if absent.")
    ] = None,
    spreading: Annotated[
        int | None,
        typer.Option(
            help="Power of the cosine by which the sea is spread, 2 or 4; long-crested if absent. "
            "It needs headings from 0 to 180."
        ),
    ] = None,
    sea_state: Annotated[
        int | None, typer.Option(help="State of the sea by WMO, 2 to 8, in place of --hs and --tp.")
    ] = None,
    place: Annotated[
        list[str] | None,
        typer.Option(
            help="A place: name,x[,freeboard[,draught]], m forward of midship; may be repeated."
        ),
    ] = None,
    hours: Annotated[float, typer.Option(help="Exposure and duration of extremes [h].")] = 3.0,
    record: RecordFiles = None,
    record_scale: RecordScale = 1.0,
    figures: DrawFigures = True,
    out: Out = None,
) -> Outcome:
    """Motions of a ship in waves, responses in a sea, and added resistance by several methods."""
    from pmmkit.files import write_results
    from pmmkit.seakeeping import (
        added_resistance,
        frequencies,
        loading_of,
        operability,
        rao,
        response,
        sea,
    )

    folder = results_folder(out, f"{stem(ship)}-seakeeping")
    hull = typed_hull(ship, draught, length)
    radii = numbers(gyration) or ()
    if len(radii) not in (0, 3):
        raise typer.BadParameter(f"--gyration {gyration!r}: write roll,pitch,yaw in m.")
    given = dict(zip(("kxx", "kyy", "kzz"), radii, strict=False))
    loading = loading_of(hull, GM=gm, roll_damping=roll_damping, **given)
    waves = None
    if sea_state is not None:
        if hs is not None or tp is not None or t1 is not None:
            raise typer.BadParameter("--sea-state stands in place of --hs, --tp and --t1.")
        waves = replace(state_of_code(sea_state).sea, spreading=spreading)
    elif hs is not None:
        waves = sea(spectrum, Hs=hs, Tp=tp, T1=t1, gamma=gamma, spreading=spreading)
    elif (tp, t1, gamma, spreading) != (None,) * 4:
        raise typer.BadParameter("--hs is needed beside a period, --gamma and --spreading.")
    courses = numbers(headings) or ()
    places = [typed_place(text) for text in place or ()]
    paces = typed_speeds(speeds, hull.L)
    damping = None
    if bilge_keels is not None:
        if roll_damping is not None or record:
            raise typer.BadParameter(
                "--bilge-keels finds the damping: leave --roll-damping and --record out."
            )
        damping = damped(bilge_keels, hull, loading, paces, waves)
        linear, quadratic = damping.roll_damping, damping.roll_quadratic
        loading = loading_of(hull, GM=gm, roll_damping=linear, roll_quadratic=quadratic, **given)
    if record and (len(paces), len(courses)) != (1, 1):
        raise typer.BadParameter("Beside --record state one speed and one heading.")
    read = read_records(record, record_scale)
    found = rao(
        hull,
        speeds=paces,
        headings_deg=courses,
        omega=numbers(omega) or frequencies(hull.L, waves, count=_FINE if record else 40),
        loading=loading,
        waves=waves if loading.roll_quadratic else None,
    )
    added = added_resistance(found)
    answers = [
        response(found, waves, speed=speed, heading_deg=heading, places=places, hours=hours)
        for speed in (found.speed.tolist() if waves else ())
        for heading in courses
        if waves
    ]
    around = {0.0, 180.0} <= {round(heading, 6) for heading in courses}
    sailed = operability(found, waves, places=places) if waves and around else None
    measured = beside_records(read, found) if read else None
    results = (
        *_files(found, added, answers, waves, figures=figures),
        *(_operability(sailed, figures=figures) if sailed else ()),
        *(measured.files(figures=figures) if measured else ()),
    )
    if figures:
        from pmmkit.views import write_seakeeping

        page = partial(
            write_seakeeping,
            found,
            added=added,
            responses=answers,
            operability=sailed,
            more=[item for item in (damping, *(measured.told if measured else ())) if item],
            figures={"Records beside the computed motions.": measured.plot()} if measured else {},
        )
        results = (*results, ("report.html", page))
    files = write_results(folder, results)
    lines = [str(found), "", *([str(damping), ""] if damping else []), str(added)]
    for answer in answers:
        lines += ["", str(answer)]
    lines += ["", str(sailed)] if sailed else []
    lines += measured.lines if measured else []
    lines += [*_means(answers, added), f"Results: {folder}"]
    lines += [f"Report:  {folder / 'report.html'}"] if figures else []
    return Outcome(
        content={
            "out": str(folder),
            "files": files,
            "ship": found.name,
            "notes": list(found.notes),
            "responses": [row for answer in answers for row in answer.rows()],
            "mean_added_resistance": _resistances(answers, added),
            "operable_share": sailed.share if sailed else None,
            "records": measured.content() if measured else None,
        },
        lines=lines,
    )


def _resistances(answers: list[Response], added: AddedResistance) -> list[dict[str, Any]]:
    return [
        {
            "speed": answer.speed,
            "heading_deg": answer.heading_deg,
            **added.mean(answer.sea, speed=answer.speed, heading_deg=answer.heading_deg),
        }
        for answer in answers
    ]


def _means(answers: list[Response], added: AddedResistance) -> list[str]:
    lines = ["", "Mean added resistance in the sea [kN]:"] if answers else []
    for row in _resistances(answers, added):
        told = ", ".join(
            f"{name} {value / 1e3:.0f}" if value == value else f"{name} -"
            for name, value in row.items()
            if name not in ("speed", "heading_deg")
        )
        lines.append(f"  {row['speed']:.2f} m/s, {row['heading_deg']:.0f}°: {told}")
    return [*lines, ""]


def _drift(part: Part) -> str:
    """The lines by which a model file takes the mean drift of a sea."""
    lines = [
        "# Mean drift of a sea, for a model. from_deg: where the waves come from, from the heading",
        "# of the approach, to starboard.",
        f"[effects.{part.effect}]",
        'source = "strip theory: pmmkit seakeeping"',
        f"[effects.{part.effect}.options]",
        *(f'{name} = "{word}"' for name, word in part.options.items()),
        f"[effects.{part.effect}.values]",
    ]
    across = part.values["angle_deg"]
    width = len(across) if isinstance(across, tuple) else 0
    for name, value in part.values.items():
        if isinstance(value, tuple):
            rows = [value[i : i + width] for i in range(0, len(value), width)]
            told = ",\n  ".join(", ".join(f"{x:.6g}" for x in row) for row in rows)
            told = f"[{told}]" if len(rows) == 1 else f"[\n  {told},\n]"
        else:
            told = repr(float(value))
        lines.append(f"{name} = {told}")
    return "\n".join(lines) + "\n"


def _operability(sailed: Operability, *, figures: bool) -> Iterator[tuple[str, Any]]:
    from pmmkit.plotting import save

    yield "operability.csv", sailed.to_pandas()
    if figures:
        yield "operability.svg", partial(save, sailed.plot())


def _files(
    found: Rao, added: AddedResistance, answers: list[Response], waves: Sea | None, *, figures: bool
) -> Iterator[tuple[str, Any]]:
    import pandas as pd

    from pmmkit.plotting import save
    from pmmkit.seakeeping import drift_part

    yield "rao.csv", found.to_pandas()
    yield "rao.nc", partial(found.to_xarray().to_netcdf, engine="h5netcdf")
    yield "added_resistance.csv", added.to_pandas()
    if waves is not None:
        yield "responses.csv", pd.DataFrame([row for one in answers for row in one.rows()])
        yield "mean_added_resistance.csv", pd.DataFrame(_resistances(answers, added))
        if waves.spreading is None and {0.0, 180.0} <= {
            round(answer.heading_deg, 6) for answer in answers
        }:
            yield "drift.toml", _drift(drift_part(found, waves))
    if figures:
        yield "rao.svg", partial(save, found.plot())
        yield "added_resistance.svg", partial(save, added.plot())
