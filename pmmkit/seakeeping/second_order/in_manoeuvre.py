"""The mean drift of a sea as a part of a manoeuvring model."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from types import MappingProxyType
from typing import Final

from pmmkit.base import DataError
from pmmkit.models import Model, Part
from pmmkit.seakeeping.hull_forms.hull import Hull
from pmmkit.seakeeping.hull_forms.particulars import hull_of, hulls, load_hull
from pmmkit.seakeeping.loading import Loading
from pmmkit.seakeeping.motions import rao
from pmmkit.seakeeping.seas import Sea
from pmmkit.seakeeping.second_order.mean_drift import Method, drift_table
from pmmkit.seakeeping.transfer import Rao

HEADINGS: Final = tuple(range(0, 181, 10))
"""Headings of the motions of a ship that manoeuvres [deg]."""
_FORCES: Final = ("DX", "DY", "DN")


def motions_in(
    model: Model,
    sea: Sea,
    *,
    speed: float | Sequence[float],
    hull: Hull | str | None = None,
    loading: Loading | None = None,
) -> Rao:
    """Motions at the headings, speeds and frequencies that a manoeuvre in a sea asks for.

    One computation serves both the mean drift (`in_waves`) and the motions on the path
    (`superposed`).

    Parameters
    ----------
    model : Model
        The ship and its water.
    sea : Sea
        Whose energy the frequencies hold.
    speed : float or sequence of float
        Of the approach [m/s], beside which stands rest; or several, rising.
    hull : Hull or str, optional
        At the scale of the model, or the name of one of the library, which is taken where it has
        the length of the model; sections are assumed from the particulars otherwise.
    loading : Loading, optional
        As `Loading.of` assumes where absent.

    Returns
    -------
    Rao

    Raises
    ------
    DataError
        If the speeds do not rise from zero or more.
    """
    speeds = [0.0, float(speed)] if isinstance(speed, int | float) else [float(x) for x in speed]
    if not speeds or speeds[0] < 0.0 or any(b <= a for a, b in pairwise(speeds)):
        told = ", ".join(f"{x:g}" for x in speeds)
        raise DataError(f"The speeds of a manoeuvre in waves must rise from 0 or more: {told}.")
    named = load_hull(hull) if isinstance(hull, str) and hull in hulls() else None
    lines = hull if isinstance(hull, Hull) else named
    if lines is None or (lines is named and lines.L != model.ship.L):
        lines = hull_of(model.ship)
    return rao(
        lines,
        speeds=speeds,
        headings_deg=HEADINGS,
        sea=sea,
        loading=loading,
        rho=model.water.rho,
        g=model.water.g,
    )


def drift_part(
    found: Rao,
    sea: Sea,
    *,
    speed: float | None = None,
    from_deg: float = 0.0,
    method: Method | None = None,
) -> Part:
    """The part ``wave_drift`` of a model for a sea.

    Parameters
    ----------
    found : Rao
        Motions at headings from 0 to 180°, at one speed or at several, between which the forces
        go with the speed of each instant.
    sea : Sea
        Its period counts, and its height where nothing else states one.
    speed : float, optional
        One of those of `found`, which then holds all through [m/s].
    from_deg : float
        Where the waves come from, from the heading of the approach, to starboard [deg].
    method : {"momentum", "sections"}, optional
        Of the drift: by what the whole ship sends out, or by what each section does alone; that of
        the engine where absent, and momentum where it has none.

    Returns
    -------
    Part

    Raises
    ------
    DataError
        If headings do not reach from 0 to 180°, or the sea is short-crested.

    Examples
    --------
    >>> from pmmkit.seakeeping.hull_forms.particulars import hull_from_particulars
    >>> from pmmkit.seakeeping.motions import rao
    >>> hull = hull_from_particulars(name="ship", L=100.0, B=18.0, d=6.0, block=0.7)
    >>> found = rao(hull, speeds=[0.0, 6.0], headings_deg=[0, 90, 180], sea=Sea(Hs=3.0, Tp=9.0))
    >>> part = drift_part(found, Sea(Hs=3.0, Tp=9.0))
    >>> part.options["coefficients"], part.values["speeds"], len(part.values["DX"])
    ('speeds', (0.0, 6.0), 6)
    """
    speeds = sorted(set(found.speed.tolist())) if speed is None else [speed]
    rows = [drift_table(found, sea, speed=each, method=method) for each in speeds]
    several = len(speeds) > 1
    values: dict[str, float | tuple[float, ...]] = {
        "Hs": sea.Hs,
        "from_deg": from_deg,
        "Tp": sea.Tp,
        **({"speeds": tuple(speeds)} if several else {}),
        "angle_deg": rows[0]["angle_deg"],
        **{name: tuple(x for row in rows for x in row[name]) for name in _FORCES},
    }
    return Part(
        effect="wave_drift",
        values=MappingProxyType(values),
        options=MappingProxyType({"coefficients": "speeds" if several else "table"}),
        source=f"{found.engine}: mean drift of {found.name}",
    )


def in_waves(
    model: Model,
    sea: Sea,
    *,
    speed: float | Sequence[float] | None = None,
    from_deg: float = 0.0,
    hull: Hull | None = None,
    loading: Loading | None = None,
    motions: Rao | None = None,
) -> Model:
    """A model that feels the mean drift of a sea.

    Parameters
    ----------
    model : Model
        Without such a part, or with one that is replaced.
    sea : Sea
        Long-crested.
    speed : float or sequence of float, optional
        Of the approach [m/s], beside which stands rest; or those of the table, rising. Between
        them forces go with the speed, beyond the first and the last they are held.
    from_deg : float
        Where the waves come from, from the heading of the approach, to starboard [deg].
    hull : Hull, optional
        At the scale of the model; sections are assumed from its particulars where absent.
    loading : Loading, optional
        As `Loading.of` assumes where absent.
    motions : Rao, optional
        In place of speed, hull and loading: those of `motions_in`, which `superposed` takes too,
        or of another program (`read_rao`).

    Returns
    -------
    Model
        Its notes say what was assumed.

    Raises
    ------
    DataError
        If not one of speed and motions is given, or speeds do not rise.

    Examples
    --------
    >>> from pmmkit.models import load_model
    >>> from pmmkit.seakeeping.hull_forms.particulars import hull_from_particulars
    >>> from pmmkit.seakeeping.motions import rao
    >>> hull = hull_from_particulars(name="KCS", L=230.0, B=32.2, d=10.8, block=0.65)
    >>> waves = Sea(Hs=4.0, Tp=10.0)
    >>> found = rao(hull, speeds=[0, 6, 12], headings_deg=[0, 90, 180], sea=waves)
    >>> rough = in_waves(load_model("kcs"), waves, motions=found, from_deg=30.0)
    >>> rough.values("wave_drift")["speeds"], rough.values("wave_drift")["from_deg"]
    ((0.0, 6.0, 12.0), 30.0)
    """
    if (speed is None) == (motions is None):
        raise DataError("Give one of them: speed, or motions.")
    found = motions
    if found is None:
        assert speed is not None
        found = motions_in(model, sea, speed=speed, hull=hull, loading=loading)
    part = drift_part(found, sea, from_deg=from_deg)
    at = ", ".join(f"{x:.3g}" for x in found.speed)
    told = f"Drift of waves by {found.engine}, Tp {sea.Tp:.3g} s, at {at} m/s."
    assumed = found.strips.hull.notes if found.strips is not None else found.notes
    return model.with_(
        parts=MappingProxyType({**model.parts, part.effect: part}),
        notes=tuple(dict.fromkeys([*model.notes, told, *assumed])),
    )
