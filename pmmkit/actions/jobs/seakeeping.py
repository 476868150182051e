"""Compute motions of a ship in waves, responses in a sea, and resistance that waves add."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from pmmkit.actions.outcome import Outcome, results_folder, written
from pmmkit.actions.setting import SettingError, numbers, setting, settings, stated, stem, words
from pmmkit.actions.shared import DrawFigures, Out
from pmmkit.actions.speeds import FROUDE, typed_list

if TYPE_CHECKING:
    from pmmkit.models import Part
    from pmmkit.seakeeping import (
        AddedResistance,
        Hull,
        Loading,
        Operability,
        Place,
        Rao,
        Response,
        RollDamping,
        Sea,
    )


# What is typed of a ship in waves: hull, speeds, places, roll damping, state of the sea.


def sea_of_code(code: int) -> Sea:
    """The sea of a state of WMO."""
    from pmmkit.seakeeping import sea_states

    states = {state.code: state for state in sea_states()}
    if code not in states:
        raise SettingError(f"--sea-state {code}: there are {', '.join(map(str, states))}.")
    return states[code].sea


def _keels(text: str) -> dict[str, float]:
    size = numbers(text) or ()
    if len(size) != 2:
        raise SettingError(f"--bilge-keels {text!r}: write breadth,length in m, or 0,0.")
    return dict(zip(("keel_breadth", "keel_length"), size, strict=True))


def typed_hull(ship: str, draught: float | None, length: float | None) -> Hull:
    """A hull from a file of offsets, or one of the library."""
    from pmmkit.seakeeping import load_hull, read_hull

    if Path(ship).suffix.lower() not in (".csv", ".mgf", ".gdf", ".stl"):
        return load_hull(ship)
    if draught is None:
        raise SettingError("A hull from a file needs --draught [m].")
    return read_hull(ship, draught=draught, L=length)


def typed_speeds(text: str, L: float) -> list[float]:
    """Speeds [m/s] of a ship of a length."""
    from math import sqrt

    return [
        speed.value * sqrt(9.81 * L) if speed.unit == FROUDE else speed.without_ship()
        for speed in typed_list(text)
    ]


def typed_place(text: str) -> Place:
    """A place out of text such as bow,150,8,20.8."""
    from pmmkit.seakeeping import Place

    name, *rest = words(text)
    try:
        values = [float(part) for part in rest]
    except ValueError:
        values = []
    if not 1 <= len(values) <= 3:
        raise SettingError(f"--place {text!r}: write name,x[,freeboard[,draught]] in m.")
    x, freeboard, draught = [*values, None, None][:3]
    assert x is not None
    return Place(name=name, x=x, freeboard=freeboard, draught=draught)


def damped(
    text: str, hull: Hull, loading: Loading, speeds: list[float], waves: Sea | None
) -> RollDamping:
    """Roll damping with bilge keels as they were typed, for the one speed and the sea there are."""
    from pmmkit.seakeeping import RollDamping

    if waves is None or len(speeds) != 1:
        raise SettingError(
            "The damping of --bilge-keels grows with the rate of roll and the speed: state a sea "
            "(--hs, --tp) and one speed."
        )
    return RollDamping.of(hull, loading, speed=speeds[0], **_keels(text))


_FINE: Final = 120
"""Frequencies beside records, between which motions lie on straight lines."""
STAGE: Final = ("predict", 5)
EXAMPLE: Final = (
    "pmmkit seakeeping tanker-320 --speeds '15.5 kn' --headings 180,135 --hs 4 --tp 9.7"
)


@settings
class LoadingSettings:
    """Hull and loading."""

    draught: float | None = setting("Draught of a hull from a file [m].", default=None)
    length: float | None = setting(
        "Length between perpendiculars of a file that does not hold it [m].", default=None
    )
    breadth: float | None = setting(
        "Breadth, beside transfer functions of WAMIT [m].", default=None
    )
    sections: str | None = setting(
        "Hull for transfer functions of another program, as SHIP: mean drift is then computed by "
        "sections too.",
        default=None,
    )
    displacement: float | None = setting(
        "Displacement in sea water [t], against which the sections are held.", default=None
    )
    lcg: float | None = setting("Centre of gravity forward of midship [m], likewise.", default=None)
    gm: float | None = setting("Metacentric height [m].", default=None)
    gyration: str | None = setting("Radii of gyration roll,pitch,yaw [m].", default=None)
    roll_damping: float | None = setting(
        "Over critical, beside that of waves; 0.05 if absent.", default=None
    )
    bilge_keels: str | None = setting(
        "Breadth,length of a bilge keel [m], 0,0 for none: roll damping by Ikeda's "
        "formulas, in the sea and at the one speed that are given.",
        default=None,
    )


@settings
class SeaSettings:
    """The sea."""

    spectrum: str = setting(
        "bretschneider, ittc, jonswap or pierson_moskowitz.", default="bretschneider"
    )
    hs: float | None = setting("Significant wave height [m].", default=None)
    tp: float | None = setting("Peak period [s].", default=None)
    t1: float | None = setting("Mean period [s], in place of --tp.", default=None)
    gamma: float | None = setting("Peakedness of a jonswap; 3.3 if absent.", default=None)
    spreading: int | None = setting(
        "Power of the cosine by which the sea is spread, 2 or 4; long-crested if absent. "
        "It needs headings from 0 to 180.",
        default=None,
    )
    sea_state: int | None = setting(
        "State of the sea by WMO, 2 to 8, in place of --hs and --tp.", default=None
    )

    @property
    def sea(self) -> Sea | None:
        """The sea; None in a calm."""
        from pmmkit.seakeeping import sea

        if self.sea_state is not None:
            if {"hs", "tp", "t1"} & set(stated(self)):
                raise SettingError("--sea-state stands in place of --hs, --tp and --t1.")
            return replace(sea_of_code(self.sea_state), spreading=self.spreading)
        if self.hs is not None:
            return sea(
                self.spectrum,
                Hs=self.hs,
                Tp=self.tp,
                T1=self.t1,
                gamma=self.gamma,
                spreading=self.spreading,
            )
        if {"tp", "t1", "gamma", "spreading"} & set(stated(self)):
            raise SettingError("--hs is needed beside a period, --gamma and --spreading.")
        return None


@settings
class MotionRecordSettings:
    """Records of motions in waves."""

    record: tuple[str, ...] = setting(
        "Records of motions in waves, such as 'runs/*.csv', beside the computed ones: "
        "columns t, wave, heave, pitch …, such as 'heave [mm]'; may be repeated.",
        default=(),
    )
    record_scale: float = setting(
        "Of a model in the records: 50 for one of 1:50.", default=1.0, least=1e-3
    )


@settings
class SeakeepingSettings:
    """What is asked."""

    ship: str = setting(
        "Offsets (.csv with x,y,z or x,breadth,draught,area; .mgf of ShipX), a mesh (.gdf, .stl), "
        "particulars (.toml), tanker-320, or a library ship; sections of the last three are "
        "assumed. Or transfer functions: .re1 of VERES, .4 of WAMIT, .nc of capytaine or pmmkit.",
        argument=True,
    )
    speeds: str | None = setting(
        "Speeds such as '10,15.5 kn', '8' [m/s] or 'Fn 0.2'; 0 if absent.", default=None
    )
    headings: str | None = setting(
        "Headings in degrees: 180 is head sea, 0 following; 180 if absent. Of transfer functions "
        "that are read all stand.",
        default=None,
    )
    hull: LoadingSettings = LoadingSettings()
    omega: str | None = setting(
        "Frequencies of the waves [rad/s]; if absent 40 from 5 L on, 120 with --record.",
        default=None,
    )
    waves: SeaSettings = SeaSettings()
    place: tuple[str, ...] = setting(
        "A place: name,x[,freeboard[,draught]], m forward of midship; may be repeated.", default=()
    )
    hours: float = setting("Exposure and duration of extremes [h].", default=3.0)
    records: MotionRecordSettings = MotionRecordSettings()
    figures: DrawFigures = True
    out: Out = None


_READ: Final = (".re1", ".4", ".nc")
"""Files of transfer functions."""


def _read(job: SeakeepingSettings) -> Rao:
    """Motions that another program computed."""
    from pmmkit.seakeeping import read_rao

    asked = {
        "--speeds": job.speeds,
        "--headings": job.headings,
        "--omega": job.omega,
        "--bilge-keels": job.hull.bilge_keels,
        "--roll-damping": job.hull.roll_damping,
        "--displacement": job.hull.displacement,
        "--lcg": job.hull.lcg,
        "--record": job.records.record or None,
    }
    if typed := [name for name, value in asked.items() if value is not None]:
        raise SettingError(f"{', '.join(typed)}: not of transfer functions that are read.")
    of = job.hull
    hull = typed_hull(of.sections, of.draught, of.length) if of.sections else None
    return read_rao(job.ship, L=of.length, B=of.breadth, hull=hull)


def _computed(
    job: SeakeepingSettings, waves: Sea | None, measured: int
) -> tuple[Rao, RollDamping | None]:
    """Motions by strip theory, and the roll damping that was estimated."""
    from pmmkit.seakeeping import Loading, frequencies, rao

    hull = typed_hull(job.ship, job.hull.draught, job.hull.length)
    radii = numbers(job.hull.gyration) or ()
    if len(radii) not in (0, 3):
        raise SettingError(f"--gyration {job.hull.gyration!r}: write roll,pitch,yaw in m.")
    given: dict[str, Any] = {
        **dict(zip(("kxx", "kyy", "kzz"), radii, strict=False)),
        "mass": job.hull.displacement and 1e3 * job.hull.displacement,
        "xG": job.hull.lcg,
    }
    loading = Loading.of(hull, GM=job.hull.gm, roll_damping=job.hull.roll_damping, **given)
    courses = numbers(job.headings) or (180.0,)
    paces = typed_speeds(job.speeds or "0", hull.L)
    damping = None
    if job.hull.bilge_keels is not None:
        if job.hull.roll_damping is not None or measured:
            raise SettingError(
                "--bilge-keels finds the damping: leave --roll-damping and --record out."
            )
        damping = damped(job.hull.bilge_keels, hull, loading, paces, waves)
        linear, quadratic = damping.roll_damping, damping.roll_quadratic
        loading = Loading.of(
            hull, GM=job.hull.gm, roll_damping=linear, roll_quadratic=quadratic, **given
        )
    if measured and (len(paces), len(courses)) != (1, 1):
        raise SettingError("Beside --record state one speed and one heading.")
    found = rao(
        hull,
        speeds=paces,
        headings_deg=courses,
        omega=numbers(job.omega) or (frequencies(hull.L, waves, count=_FINE) if measured else None),
        sea=waves,
        loading=loading,
    )
    return found, damping


def seakeeping(job: SeakeepingSettings) -> Outcome:
    """Do what is asked."""
    import numpy as np

    from pmmkit.seakeeping import Operability, added_resistance, beside_records, response

    folder = results_folder(job.out, f"{stem(job.ship)}-seakeeping")
    waves = job.waves.sea
    places = [typed_place(text) for text in job.place]
    if Path(job.ship).suffix.lower() in _READ:
        found, damping = _read(job), None
    else:
        found, damping = _computed(job, waves, len(job.records.record))
    courses = [round(float(heading), 9) for heading in np.degrees(found.heading)]
    known = found.strips is not None or found.second_order is not None
    added = added_resistance(found) if known else None
    answers = [
        response(found, waves, speed=speed, heading_deg=heading, places=places, hours=job.hours)
        for speed in (found.speed.tolist() if waves else ())
        for heading in courses
        if waves
    ]
    around = {0.0, 180.0} <= {round(heading, 6) for heading in courses}
    sailed = Operability.of(found, waves, places=places) if waves and around else None
    kept = job.records
    measured = beside_records(kept.record, found, scale=kept.record_scale) if kept.record else None
    results = (
        *_files(found, added, answers, waves, figures=job.figures),
        *(_operability(sailed, figures=job.figures) if sailed else ()),
        *(measured.files(figures=job.figures) if measured else ()),
    )
    if job.figures:
        from pmmkit.views import write_report

        page = partial(
            write_report,
            found,
            added=added,
            responses=answers,
            operability=sailed,
            more=[item for item in (damping, *(measured.told if measured else ())) if item],
            figures={"Records beside the computed motions.": measured.plot()} if measured else {},
        )
        results = (*results, ("report.html", page))
    lines = [str(found), "", *([str(damping), ""] if damping else [])]
    lines.append(str(added) if added else "No hull and no mean drift: no added resistance.")
    for answer in answers:
        lines += ["", str(answer)]
    lines += ["", str(sailed)] if sailed else []
    lines += measured.lines if measured else []
    lines += _means(answers, added)
    content = {
        "ship": found.name,
        "notes": list(found.notes),
        "responses": [row for answer in answers for row in answer.rows()],
        "mean_added_resistance": _resistances(answers, added),
        "operable_share": sailed.share if sailed else None,
        "records": measured.content() if measured else None,
    }
    told = [f"Report:  {folder / 'report.html'}"] if job.figures else []
    return written(folder, results, content, lines).then(*told)


def _resistances(answers: list[Response], added: AddedResistance | None) -> list[dict[str, Any]]:
    if added is None:
        return []
    return [
        {
            "speed": answer.speed,
            "heading_deg": answer.heading_deg,
            **added.mean(answer.sea, speed=answer.speed, heading_deg=answer.heading_deg),
        }
        for answer in answers
    ]


def _means(answers: list[Response], added: AddedResistance | None) -> list[str]:
    rows = _resistances(answers, added)
    lines = ["", "Mean added resistance in the sea [kN]:"] if rows else []
    for row in rows:
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
        f'source = "{part.source}"',
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

    yield "operability.csv", sailed.to_pandas()
    if figures:
        yield "operability.svg", sailed.plot().save


def _files(
    found: Rao,
    added: AddedResistance | None,
    answers: list[Response],
    waves: Sea | None,
    *,
    figures: bool,
) -> Iterator[tuple[str, Any]]:
    import pandas as pd

    from pmmkit.seakeeping import drift_part

    whole = found if added is None else replace(found, second_order=added.drift)
    yield "rao.csv", whole.to_pandas()
    yield "rao.nc", partial(whole.to_xarray().to_netcdf, engine="h5netcdf")
    if found.strips is not None:
        yield "hull.gdf", found.strips.hull.write
        if found.moored:
            yield "capytaine.nc", partial(found.to_capytaine().to_netcdf, engine="h5netcdf")
    if waves is not None:
        yield "responses.csv", pd.DataFrame([row for one in answers for row in one.rows()])
    if added is not None:
        yield "added_resistance.csv", added.to_pandas()
    if waves is not None and added is not None:
        yield "mean_added_resistance.csv", pd.DataFrame(_resistances(answers, added))
        if waves.spreading is None and {0.0, 180.0} <= {
            round(answer.heading_deg, 6) for answer in answers
        }:
            yield "drift.toml", _drift(drift_part(found, waves))
    if figures:
        yield "rao.svg", found.plot().save
        if added is not None:
            yield "added_resistance.svg", added.plot().save
