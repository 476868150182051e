"""Transfer functions of other programs: VERES, WAMIT, capytaine, and tables.

Each has axes of its own. Turned half about z (VERES: x aft, y to starboard) surge, sway, roll,
pitch and their forces change sign. Mirrored at the middle (WAMIT, capytaine: waves of 90° run to
port) sway, roll and yaw do. Where time goes as exp(-iωt) (capytaine) all are conjugate.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.base import DataError, Problem
from pmmkit.numerics import Array
from pmmkit.seakeeping.hull_forms.hull import Hull
from pmmkit.seakeeping.lengthwise import Complex
from pmmkit.seakeeping.loading import Loading
from pmmkit.seakeeping.strips import critical_damping, strips_of
from pmmkit.seakeeping.transfer import DRIFT, MIRRORED, MODES, Rao

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

TURNED: Final = np.array([-1.0, -1.0, 1.0, -1.0, -1.0, 1.0])
"""Modes in axes turned half about z."""
HORIZONTAL: Final = (0, 1, 5)
"""Modes of the mean drift."""
TABLE: Final = ("speed", "heading_deg", "omega", *MODES, *(f"{mode}_phase" for mode in MODES))
"""Columns that a table needs, as `Rao.to_pandas` writes them."""


@dataclass(frozen=True, kw_only=True)
class _Given:
    """What the caller knows beside a file."""

    L: float | None
    B: float | None
    x: float
    z: float
    rho: float
    g: float


@dataclass(frozen=True, kw_only=True, eq=False)
class _Found:
    """What a file holds: axes and modes as `Rao` has them, about an origin `z` above the water.

    `motion`, `force` (6, speeds, headings, frequencies), `second_order` (3, …) about the origin.
    """

    engine: str
    name: str
    L: float
    B: float
    x: float
    z: float
    rho: float
    g: float
    speed: Array
    heading: Array
    omega: Array
    motion: Complex
    force: Complex
    second_order: Array | None = None
    notes: tuple[str, ...] = ()


def read_rao(
    path: str | Path,
    *,
    L: float | None = None,
    B: float | None = None,
    x: float = 0.0,
    z: float = 0.0,
    hull: Hull | None = None,
    loading: Loading | None = None,
    rho: float = 1025.0,
    g: float = 9.81,
) -> Rao:
    """Transfer functions that another program computed.

    Parameters
    ----------
    path : path
        ``.re1`` of VERES, with ``.re8`` (forces of the waves) and ``.re2`` (mean drift) of the same
        name beside it; ``.4`` of WAMIT, with ``.3`` or ``.2`` and ``.8`` or ``.9``; a dataset of
        capytaine (``.nc``); ``rao.nc`` or a ``.csv`` as pmmkit writes them.
    L, B : float, optional
        Length between perpendiculars and breadth [m], which files of WAMIT and capytaine do not
        hold; those of `hull` where it is given.
    x, z : float
        Where the origin of such a file stands: forward of midship, above the water [m].
    hull : Hull, optional
        With it mean drift is also computed from these motions by strips.
    loading : Loading, optional
        Of that hull; as `Loading.of` assumes where absent.
    rho, g : float
        Density [kg/m³] and gravity [m/s²] where the file does not say.

    Returns
    -------
    Rao

    Raises
    ------
    DataError
        If the file is of no such form, is not whole, or leaves open what is not stated.

    Notes
    -----
    WAMIT's numbers are made dimensional by the length scale of the ``.gdf`` beside them (1 m where
    there is none). Its second file of mean drift, ``.9``, is by pressures; ``.8``, by momentum, is
    taken first. The yaw moment of ``.re2`` is taken over ρgB², as the MSS toolbox does
    (read_veres_WD.m, 2007); no document of VERES that says so is known here.
    """
    path = Path(path)
    read = _READERS.get(path.suffix.lower())
    if read is None:
        raise DataError(
            f"{path.name}: transfer functions are read from {', '.join(_READERS)} files."
        )
    if hull is not None:
        L, B = L or hull.L, B or float(hull.breadths.max())
    found = read(path, _Given(L=L, B=B, x=x, z=z, rho=rho, g=g))
    _check(found, path)
    order = np.argsort(found.heading)
    motion, force = found.motion.copy(), found.force.copy()
    # a point on the water moves as the origin and by the rotations about it: r × (0, 0, -z)
    motion[0] -= found.z * motion[4]
    motion[1] += found.z * motion[3]
    force[3] -= found.z * force[1]
    force[4] += found.z * force[0]
    second = found.second_order
    if second is not None:
        second = second[:, :, order]
        second = np.stack([second[0], second[1], second[2] + found.x * second[1]])
    k = found.omega**2 / found.g
    heading = found.heading[order]
    encounter = found.omega - np.multiply.outer(np.multiply.outer(found.speed, np.cos(heading)), k)
    strips, damping = None, np.zeros(encounter.shape)
    if hull is not None:
        strips = strips_of(hull, float(np.abs(encounter).max()), g=found.g)
        loading = loading or Loading.of(hull)
        damping += loading.roll_damping * critical_damping(
            strips, loading, found.rho, found.speed[:, None, None], encounter
        )
    return Rao(
        name=found.name or path.stem,
        engine=found.engine,
        L=found.L,
        B=found.B,
        x=found.x,
        speed=found.speed,
        heading=heading,
        omega=found.omega,
        encounter=encounter,
        motion=motion[:, :, order],
        force=force[:, :, order],
        quasi_static=np.zeros(encounter.shape, dtype=bool),
        roll_damping=damping,
        strips=strips,
        loading=loading if hull is not None else None,
        second_order=second,
        rho=found.rho,
        g=found.g,
        notes=(f"Read from {path.name}, made by {found.engine}.", *found.notes),
    )


def _check(found: _Found, path: Path) -> None:
    """Refuse what no ship can have."""
    wrong = []
    if not found.omega.size or (found.omega <= 0.0).any() or (np.diff(found.omega) <= 0.0).any():
        wrong.append("its frequencies are not positive and rising")
    if np.unique(np.round(found.heading, 6)).size != found.heading.size or not found.heading.size:
        wrong.append("a heading stands twice, or there is none")
    if not np.isfinite(found.motion[2]).any():
        wrong.append("it holds no heave")
    if not (found.L > 0.0 and found.B > 0.0):
        wrong.append("length and breadth must be positive: state L and B [m]")
    if wrong:
        raise DataError([Problem(message=one, file=str(path)) for one in wrong], title="Not read")


def _stated(given: _Given, path: Path) -> tuple[float, float]:
    """Length and breadth, which must be stated."""
    if given.L is None or given.B is None:
        raise DataError(
            Problem(
                message="holds no length and no breadth of the ship",
                file=str(path),
                remedy="State L and B [m], or give the hull.",
            )
        )
    return given.L, given.B


def _numbers(path: Path) -> Iterator[tuple[int, list[float]]]:
    """Lines of numbers alone, each with its number; others are left out."""
    try:
        text = path.read_text(encoding="latin-1")
    except OSError as error:
        raise DataError(Problem(message=f"cannot be read: {error}", file=str(path))) from error
    for line, words in enumerate(map(str.split, text.splitlines()), start=1):
        try:
            row = [float(word) for word in words]
        except ValueError:
            continue
        if row:
            yield line, row


def _short(path: Path) -> DataError:
    return DataError(
        Problem(message="ends before all that its head announces was read", file=str(path))
    )


def _veres(path: Path, given: _Given) -> _Found:
    """VERES: 0° is head sea, waves of 90° run to starboard; x aft, y to starboard, z up.

    The file says all that the caller could.
    """
    del given
    head, speed, heading, omega, motion = _veres_table(path)
    (rho, g), (L, B, T), (aft, _) = head[:3]
    shape = motion.shape
    beside = path.with_suffix(".re8")
    force = _veres_table(beside)[4] if beside.is_file() else np.full(shape, np.nan, dtype=complex)
    if force.shape != shape:
        raise DataError(
            Problem(message=f"has other headings or speeds than {path.name}", file=str(beside))
        )
    drifts = path.with_suffix(".re2")
    second = _veres_drift(drifts, shape[1:]) if drifts.is_file() else None
    if second is not None:
        # ahead and to port, where VERES has aft and to starboard
        second *= rho * g * B**2 * np.array([-1.0 / L, -1.0 / L, 1.0])[:, None, None, None]
    turned = TURNED[:, None, None, None]
    lines = path.read_text(encoding="latin-1").splitlines()
    return _Found(
        engine=_engine(lines[0]),
        name=lines[2].partition(":")[2].strip() if len(lines) > 2 else "",
        L=L,
        B=B,
        x=-aft,
        z=head[3][4] - T,
        rho=rho,
        g=g,
        speed=speed,
        heading=np.radians(180.0 - heading),
        omega=omega,
        motion=motion * turned,
        force=force * turned,
        second_order=second,
    )


def _engine(line: str) -> str:
    """Program and version out of the first line of a file of VERES."""
    version = line.partition("Version")[2].split()
    return f"VERES {version[0]}" if version else "VERES"


def _veres_table(path: Path) -> tuple[list[list[float]], Array, Array, Array, Complex]:
    """Head, speeds, headings, frequencies and modes (6, …) of ``.re1`` or ``.re8``."""
    rows = _numbers(path)
    try:
        head = [next(rows)[1] for _ in range(4)]
        if [len(row) for row in head] != [2, 3, 2, 4] or head[3][3] != 6:
            raise DataError(Problem(message="has not the head of VERES", file=str(path)))
        speeds, headings, frequencies, modes = (int(x) for x in head.pop())
        U, beta, omega = np.zeros(speeds), np.zeros(headings), np.zeros(frequencies)
        values: Complex = np.zeros((modes, speeds, headings, frequencies), dtype=complex)
        for a in range(speeds):
            head.append(next(rows)[1])
            U[a] = head[-1][0]
            for b in range(headings):
                beta[b] = next(rows)[1][0]
                for c in range(frequencies):
                    omega[c] = next(rows)[1][0]
                    for mode in range(modes):
                        _, real, imaginary = next(rows)[1]
                        values[mode, a, b, c] = complex(real, imaginary)
    except DataError:
        raise
    except (StopIteration, ValueError, IndexError) as error:
        raise _short(path) from error
    return head, U, beta, omega, values


def _veres_drift(path: Path, shape: tuple[int, ...]) -> Array:
    """Mean drift over ρgζ²B²/L, ρgζ²B²/L, ρgζ²B² (3, speeds, headings, frequencies)."""
    rows = _numbers(path)
    try:
        head = [next(rows)[1] for _ in range(3)]
        speeds, headings, frequencies = (int(x) for x in head[2])
        if (speeds, headings, frequencies) != shape:
            raise DataError(
                Problem(message="has other headings or speeds than the motions", file=str(path))
            )
        values = np.zeros((3, *shape))
        for a in range(speeds):
            for b in range(headings):
                next(rows)
                for c in range(frequencies):
                    values[:, a, b, c] = next(rows)[1][1:4]
    except DataError:
        raise
    except (StopIteration, ValueError, IndexError) as error:
        raise _short(path) from error
    return values


def _wamit(path: Path, given: _Given) -> _Found:
    """WAMIT at rest: x forward, y to port, z up, waves of 0° run ahead, of 90° to port."""
    L, B = _stated(given, path)
    scale, g, notes = _wamit_scale(path, given.g)
    omega, heading, moved = _wamit_table(path, 2)
    rotations = np.arange(6) > 2
    mirrored = MIRRORED[:, None, None]
    motion = moved / scale ** rotations[:, None, None] * mirrored
    unit = given.rho * g * scale ** (1.0 + rotations)[:, None, None] * mirrored
    excited, drifts = _first_beside(path, ".3", ".2"), _first_beside(path, ".8", ".9")
    force = np.full_like(motion, np.nan)
    if excited is not None:
        force = _wamit_at(excited, 2, omega, heading) * scale * unit
    second = None
    if drifts is not None:
        mean = (_wamit_at(drifts, 3, omega, heading) * unit).real
        second = mean[list(HORIZONTAL)][:, None]
    return _Found(
        engine="WAMIT",
        name="",
        L=L,
        B=B,
        x=given.x,
        z=given.z,
        rho=given.rho,
        g=g,
        speed=np.zeros(1),
        heading=heading,
        omega=omega,
        motion=motion[:, None],
        force=force[:, None],
        second_order=second,
        notes=notes,
    )


def _first_beside(path: Path, *suffixes: str) -> Path | None:
    """The first of the files of its name with these endings that there is."""
    return next((x for x in map(path.with_suffix, suffixes) if x.is_file()), None)


def _wamit_scale(path: Path, g: float) -> tuple[float, float, tuple[str, ...]]:
    """Length scale and gravity of the ``.gdf`` beside; 1 m where there is none."""
    geometry = path.with_suffix(".gdf")
    if geometry.is_file():
        lines = geometry.read_text(encoding="latin-1").splitlines()
        try:
            scale, gravity = (float(word) for word in lines[1].split()[:2])
        except (IndexError, ValueError) as error:
            raise DataError(
                Problem(message="has no length scale and gravity", file=str(geometry), row=2)
            ) from error
        return scale, gravity, ()
    return 1.0, g, (f"No {geometry.name} beside it: its length scale is taken as 1 m.",)


def _wamit_rows(path: Path, angles: int) -> Iterator[tuple[float, float, int, complex]]:
    """Frequency, heading, mode and value of each row; of two wave directions one alone counts.

    angles: 2 where one column of headings stands before the mode, 3 where two do.
    """
    width = angles + 5
    for line, row in _numbers(path):
        if len(row) != width:
            raise DataError(
                Problem(message=f"has {len(row)} numbers, not {width}", file=str(path), row=line)
            )
        period, mode = row[0], int(row[angles])
        if mode < 1 or mode > 6 or (angles == 3 and row[1] != row[2]) or period <= 0.0:
            continue
        yield 2.0 * math.pi / period, row[1], mode - 1, complex(row[-2], row[-1])


def _wamit_table(path: Path, angles: int) -> tuple[Array, Array, Complex]:
    """Frequencies, headings [rad] and modes (6, headings, frequencies); what is absent is NaN."""
    rows = list(_wamit_rows(path, angles))
    omega, c = np.unique(np.array([row[0] for row in rows]), return_inverse=True)
    heading, b = np.unique(np.array([row[1] for row in rows]), return_inverse=True)
    values: Complex = np.full((6, heading.size, omega.size), np.nan, dtype=complex)
    if rows:
        values[[row[2] for row in rows], b, c] = [row[3] for row in rows]
    return omega, np.radians(heading), values


def _wamit_at(path: Path, angles: int, omega: Array, heading: Array) -> Complex:
    """As `_wamit_table`, at the frequencies and headings of the motions; NaN where absent."""
    there, directions, values = _wamit_table(path, angles)
    found: Complex = np.full((6, heading.size, omega.size), np.nan, dtype=complex)
    _, b, own_b = np.intersect1d(heading, directions, return_indices=True)
    _, c, own_c = np.intersect1d(omega, there, return_indices=True)
    found[:, b[:, None], c] = values[:, own_b[:, None], own_c]
    return found


def _netcdf(path: Path, given: _Given) -> _Found:
    """A dataset of capytaine, or one that `Rao.to_xarray` made."""
    import xarray as xr

    try:
        with xr.open_dataset(path, engine="h5netcdf") as opened:
            data = opened.load()
    except (OSError, ValueError, KeyError) as error:
        raise DataError(Problem(message=f"cannot be read: {error}", file=str(path))) from error
    if "heave_amplitude" in data:
        frame = data.to_dataframe().reset_index().rename(columns={"heading": "heading_deg"})
        frame = frame.rename(columns={f"{mode}_amplitude": mode for mode in MODES})
        told = {
            name: float(data.attrs[key]) for name, key in _ATTRIBUTES.items() if key in data.attrs
        }
        found = _table(frame, path, replace(given, **told))
        return replace(found, engine=str(data.attrs["source"]), name=str(data.attrs["name"]))
    if "added_mass" in data and "radiation_damping" in data:
        return _capytaine(data, path, given)
    raise DataError(Problem(message="is no dataset of capytaine or of pmmkit", file=str(path)))


_ATTRIBUTES: Final = {
    "L": "length_m",
    "B": "breadth_m",
    "x": "origin_m",
    "rho": "density_kg_m3",
    "g": "gravity_m_s2",
}
"""What `Rao.to_xarray` says of itself."""


def _csv(path: Path, given: _Given) -> _Found:
    """A table as `Rao.to_pandas` makes it: amplitudes [m/m, rad/m] and leads [rad]."""
    import pandas as pd

    try:
        frame = pd.read_csv(path)
    except (OSError, ValueError) as error:
        raise DataError(Problem(message=f"cannot be read: {error}", file=str(path))) from error
    return _table(frame, path, given)


def _table(frame: pd.DataFrame, path: Path, given: _Given) -> _Found:
    """Rows for each speed, heading and frequency, in any order."""
    L, B = _stated(given, path)
    missing = [name for name in TABLE if name not in frame]
    if missing:
        raise DataError(Problem(message=f"has no column {', '.join(missing)}", file=str(path)))
    columns = frame[list(TABLE)].to_numpy(float).T
    axes, places = zip(
        *(np.unique(column, return_inverse=True) for column in columns[:3]), strict=True
    )
    shape = tuple(axis.size for axis in axes)
    motion: Complex = np.full((6, *shape), np.nan, dtype=complex)
    motion[:, places[0], places[1], places[2]] = columns[3:9] * np.exp(1j * columns[9:])

    def table(names: Sequence[str]) -> Array:
        values = np.full((len(names), *shape), np.nan)
        for row, name in zip(values, names, strict=True):
            if name in frame:
                row[places[0], places[1], places[2]] = frame[name].to_numpy(float)
        return values

    size, lead = (table([f"{mode}_force{of}" for mode in MODES]) for of in ("", "_phase"))
    pushed = table(DRIFT)
    pushed[2] -= given.x * pushed[1]  # about the origin, as files of others
    return _Found(
        engine="a table",
        name="",
        L=L,
        B=B,
        x=given.x,
        z=given.z,
        rho=given.rho,
        g=given.g,
        speed=axes[0],
        heading=np.radians(axes[1]),
        omega=axes[2],
        motion=motion,
        force=size * np.exp(1j * lead),
        second_order=pushed if np.isfinite(pushed).all() else None,
    )


def _capytaine(data: xr.Dataset, path: Path, given: _Given) -> _Found:
    """Motions by added mass, damping, inertia and stiffness of capytaine, at rest.

    (K - ω²(M + A) - iωB) X = F, where time goes as exp(-iωt).
    """
    L, B = _stated(given, path)
    needed = ("inertia_matrix", "hydrostatic_stiffness", "added_mass", "radiation_damping")
    missing = [name for name in needed if name not in data]
    excited = [name for name in ("Froude_Krylov_force", "diffraction_force") if name in data]
    if "excitation_force" in data:
        excited = ["excitation_force"]
    if missing or not excited:
        absent = ", ".join([*missing, *([] if excited else ["excitation_force"])])
        raise DataError(Problem(message=f"has no {absent}", file=str(path)))
    if "forward_speed" in data.dims or float(data.get("forward_speed", 0.0)) != 0.0:
        raise DataError(Problem(message="is not of a ship at rest alone", file=str(path)))
    modes = [mode.capitalize() for mode in MODES]
    at = {"radiating_dof": modes, "influenced_dof": modes}
    try:
        mass, still, added, damping = (
            data[name].sel(at).transpose("radiating_dof", "influenced_dof", ...) for name in needed
        )
        forces = [
            data[name].sel(influenced_dof=modes).transpose("influenced_dof", "wave_direction", ...)
            for name in excited
        ]
    except KeyError as error:
        raise DataError(
            Problem(message=f"has not all of {', '.join(modes)}", file=str(path))
        ) from error
    F: Complex = np.sum(
        [
            force.sel(complex="re").values + 1j * force.sel(complex="im").values
            if "complex" in force.dims
            else force.values
            for force in forces
        ],
        axis=0,
    )
    omega = data["omega"].values.astype(float)
    w = omega[:, None, None]
    radiated, damped = (np.moveaxis(x.values, -1, 0) for x in (added, damping))
    # rows are forces, columns motions
    system = np.swapaxes(still.values - w**2 * (mass.values + radiated) - 1j * w * damped, 1, 2)
    moved = np.linalg.solve(system, np.moveaxis(F, -1, 0))
    order = np.argsort(omega)
    mirrored = MIRRORED[:, None, None]
    motion, force = (
        (np.moveaxis(x, 0, -1) * mirrored).conj()[..., order][:, None]
        for x in (moved, np.moveaxis(F, -1, 0))
    )
    return _Found(
        engine="capytaine",
        name=next((str(data[x].values) for x in ("body_name", "body") if x in data.coords), ""),
        L=L,
        B=B,
        x=given.x,
        z=given.z,
        rho=float(data.get("rho", given.rho)),
        g=float(data.get("g", given.g)),
        speed=np.zeros(1),
        heading=data["wave_direction"].values.astype(float),
        omega=omega[order],
        motion=motion,
        force=force,
        notes=("Roll is damped by waves alone.",),
    )


_READERS: Final[Mapping[str, Callable[[Path, _Given], _Found]]] = {
    ".re1": _veres,
    ".4": _wamit,
    ".nc": _netcdf,
    ".csv": _csv,
}
