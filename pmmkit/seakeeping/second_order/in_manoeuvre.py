"""The mean drift of a sea as a part of a manoeuvring model."""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

from pmmkit.effects.waves import WAVE_DRIFT
from pmmkit.errors import DataError
from pmmkit.models import Model
from pmmkit.models.model import Part
from pmmkit.seakeeping.hulls.hull import Hull
from pmmkit.seakeeping.hulls.library import hull_of
from pmmkit.seakeeping.loading import Loading
from pmmkit.seakeeping.motions import frequencies, rao
from pmmkit.seakeeping.seas import Sea
from pmmkit.seakeeping.second_order.mean_drift import drift_table
from pmmkit.seakeeping.transfer import Rao

HEADINGS: Final = tuple(range(0, 181, 15))
"""Headings of a table of drift [deg]."""
_REST: Final = ("DX", "DY", "DN")


def drift_part(found: Rao, sea: Sea, *, speed: float | None = None, from_deg: float = 0.0) -> Part:
    """The part ``wave_drift`` of a model for a sea.

    Parameters
    ----------
    found : Rao
        Motions at headings from 0 to 180°, at one speed, or at rest and at one speed: then the
        forces go with the speed of each instant between both.
    sea : Sea
        Its period counts, and its height where nothing else states one.
    speed : float, optional
        One of those of `found`, which then holds all through [m/s].
    from_deg : float
        Where the waves come from, from the heading of the approach, to starboard [deg].

    Returns
    -------
    Part

    Raises
    ------
    DataError
        If there are other speeds, or headings do not reach from 0 to 180°.

    Examples
    --------
    >>> from pmmkit.seakeeping import hull_from_particulars, rao
    >>> hull = hull_from_particulars(name="ship", L=100.0, B=18.0, d=6.0, block=0.7)
    >>> found = rao(hull, speeds=[0.0, 6.0], headings_deg=[0, 90, 180], omega=[0.5, 0.7, 0.9])
    >>> part = drift_part(found, Sea(Hs=3.0, Tp=9.0))
    >>> part.options["coefficients"], part.values["speed"], len(part.values["DX_rest"])
    ('speeds', 6.0, 3)
    """
    speeds = found.speed.tolist() if speed is None else [speed]
    two = len(speeds) == 2 and speeds[0] == 0.0 < speeds[1]
    if len(speeds) != 1 and not two:
        raise DataError("A model takes the drift at one speed, or at rest and at one speed.")
    values: dict[str, float | tuple[float, ...]] = {
        "Hs": sea.Hs,
        "from_deg": from_deg,
        "Tp": sea.Tp,
        **drift_table(found, sea, speed=speeds[-1]),
    }
    if two:
        rest = drift_table(found, sea, speed=0.0)
        values |= {"speed": speeds[-1], **{f"{name}_rest": rest[name] for name in _REST}}
    return Part(
        effect=WAVE_DRIFT.name,
        values=MappingProxyType(values),
        options=MappingProxyType({"coefficients": "speeds" if two else "table"}),
        source=f"strip theory: mean drift of {found.name}",
    )


def in_waves(
    model: Model,
    sea: Sea,
    *,
    speed: float,
    from_deg: float = 0.0,
    hull: Hull | None = None,
    loading: Loading | None = None,
) -> Model:
    """A model that feels the mean drift of a sea, by strip theory.

    Parameters
    ----------
    model : Model
        Without such a part, or with one that is replaced.
    sea : Sea
        Long-crested.
    speed : float
        Of the approach [m/s]; between it and rest forces go with the speed.
    from_deg : float
        Where the waves come from, from the heading of the approach, to starboard [deg].
    hull : Hull, optional
        At the scale of the model; sections are assumed from its particulars where absent.
    loading : Loading, optional
        As `pmmkit.seakeeping.loading_of` assumes where absent.

    Returns
    -------
    Model
        Its notes say what was assumed.

    Examples
    --------
    >>> from pmmkit.models import load_model
    >>> rough = in_waves(load_model("kcs"), Sea(Hs=4.0, Tp=10.0), speed=12.0, from_deg=30.0)
    >>> rough.parts["wave_drift"].options["coefficients"], rough.values("wave_drift")["from_deg"]
    ('speeds', 30.0)
    """
    lines = hull_of(model.ship) if hull is None else hull
    found = rao(
        lines,
        speeds=[0.0, speed],
        headings_deg=HEADINGS,
        omega=frequencies(lines.L, sea),
        loading=loading,
        rho=model.water.rho,
        g=model.water.g,
    )
    part = drift_part(found, sea, from_deg=from_deg)
    told = f"Drift of waves by strip theory, Tp {sea.Tp:.3g} s, rest and {speed:.3g} m/s."
    return model.with_(
        parts=MappingProxyType({**model.parts, part.effect: part}),
        notes=tuple(dict.fromkeys([*model.notes, told, *lines.notes])),
    )
