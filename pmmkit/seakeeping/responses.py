"""Responses of a ship in a sea: significant and extreme values, comfort, wet decks, slamming."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from pmmkit.errors import DataError
from pmmkit.numerics import Array
from pmmkit.presentation import counted
from pmmkit.seakeeping.answers import HOURS, AtPlace, Moments, Place, Response
from pmmkit.seakeeping.arrays import Complex
from pmmkit.seakeeping.asked import between, nearest
from pmmkit.seakeeping.seas import Sea
from pmmkit.seakeeping.sickness import dose_weight, incidence_in_waves, vomiting_by_dose
from pmmkit.seakeeping.transfer import MODES, Rao


def moments(transfer: Complex, encounter: Array, omega: Array, sea: Sea) -> Moments:
    """Moments of a response in a long-crested sea, integrated over the frequency of the waves.

    In following seas several waves share a frequency of encounter, so that a spectrum over it is
    singular; its moments over ω are not.

    Parameters
    ----------
    transfer : array of complex
        Per metre of wave amplitude.
    encounter, omega : array
        Of the same shape: frequencies of encounter and of the waves [rad/s].
    sea : Sea
        Its spectrum is taken.

    Examples
    --------
    >>> omega = np.linspace(0.2, 4.0, 400)
    >>> wave = moments(np.ones(400) + 0j, omega, omega, Sea(Hs=3.0, Tp=9.0))
    >>> round(2 * wave.significant, 2)
    3.0
    """
    energy = np.abs(transfer) ** 2 * sea.spectrum(omega)
    m0, m2, m4 = (float(np.trapezoid(energy * np.abs(encounter) ** n, omega)) for n in (0, 2, 4))
    return Moments(m0=m0, m2=m2, m4=m4)


def response(
    rao: Rao,
    sea: Sea,
    *,
    speed: float | None = None,
    heading_deg: float | None = None,
    places: Sequence[Place] = (),
    hours: float = HOURS,
) -> Response:
    """What a ship does in a sea.

    Parameters
    ----------
    rao : Rao
        Transfer functions; for a short-crested sea at headings around the one that is asked.
    sea : Sea
        The sea.
    speed, heading_deg : float, optional
        One of those of `rao` [m/s, deg]; may be absent where it has one.
    places : sequence of Place
        Where motions are felt.
    hours : float
        Exposure of the motion sickness, and duration of extremes [h].

    Returns
    -------
    Response

    Raises
    ------
    DataError
        If `rao` lacks the speed or a heading, or its frequencies leave out a part of the sea.
    """
    a = nearest(rao.speed, speed, "speed [m/s]")
    mean = np.degrees(rao.heading)
    b = nearest(mean, heading_deg, "heading_deg")
    headings, shares = sea.directions(float(mean[b]), 13)
    share = float(np.trapezoid(sea.spectrum(rao.omega), rao.omega)) / max(sea.moment(0), 1e-30)
    if sea.Hs > 0 and share < 0.9:
        raise DataError(
            f"The frequencies {rao.omega[0]:.2f} to {rao.omega[-1]:.2f} rad/s hold "
            f"{100 * share:.0f} % of the energy of the sea, whose peak is at "
            f"{sea.peak:.2f} rad/s: compute more of them."
        )
    places_ = tuple(_at_place(rao, a, headings, shares, sea, place, hours) for place in places)
    found, absent = {}, []
    for mode in MODES:
        one = _summed(rao, rao.mode(mode)[a], a, headings, shares, sea)
        if math.isfinite(one.m0):
            found[mode] = one
        else:
            absent.append(mode)
    notes = [f"The frequencies hold {100 * share:.1f} % of the energy of the sea."]
    if absent:
        notes.append(
            f"{', '.join(absent)}: not known where waves meet the ship too slowly, so not given."
        )
    if rao.notes:
        notes.append(
            f"The motions have {counted(len(rao.notes), 'note')} of their own: print them."
        )
    return Response(
        ship=rao.name,
        sea=sea,
        speed=float(rao.speed[a]),
        heading_deg=float(mean[b]),
        motions=found,
        places=places_,
        hours=hours,
        notes=tuple(notes),
    )


def _summed(
    rao: Rao, transfer: Complex, speed: int, headings: Array, shares: Array, sea: Sea
) -> Moments:
    """Moments of a response (headings, frequencies), summed over the directions of the sea."""
    total = np.zeros(3)
    for heading, share in zip(headings, shares, strict=True):
        near, weight = between(rao.heading, float(heading))
        for b, part in zip(near, weight, strict=True):
            one = moments(transfer[b], rao.encounter[speed, b], rao.omega, sea)
            total += share * part * np.array([one.m0, one.m2, one.m4])
    return Moments(m0=float(total[0]), m2=float(total[1]), m4=float(total[2]))


def relative_motion(rao: Rao, place: Place) -> Complex:
    """Vertical motion of a place against the undisturbed wave, (speeds, headings, frequencies)."""
    forward = place.x - rao.strips.hull.hydrostatics.xB
    k, beta = rao.wavenumber, rao.heading[:, None]
    wave = np.exp(-1j * k * (forward * np.cos(beta) - place.y * np.sin(beta)))
    return np.asarray(rao.at_point(place.x, place.y, place.z)[2] - wave)


def _at_place(
    rao: Rao, a: int, headings: Array, shares: Array, sea: Sea, place: Place, hours: float
) -> AtPlace:
    up, against = rao.at_point(place.x, place.y, place.z)[2, a], relative_motion(rao, place)[a]

    def summed(transfer: Complex) -> Moments:
        return _summed(rao, transfer, a, headings, shares, sea)

    hard = -(rao.encounter[a] ** 2) * up
    felt, relative = summed(hard), summed(against)
    weighted = summed(hard * dose_weight(rao.encounter[a]))
    dose = math.sqrt(weighted.m0 * 3600 * hours)
    wet = slam = None
    if place.freeboard is not None:
        wet = relative.exceeded(place.freeboard)
    if place.draught is not None:
        # Ochi (1964): the keel comes out and enters faster than .093 √(gL)
        fast = 0.093 * math.sqrt(rao.g * rao.L)
        slam = relative.exceeded(place.draught) * math.exp(-(fast**2) / (2 * relative.m2))
    waves = 3600 / relative.period
    return AtPlace(
        place=place,
        vertical=summed(up),
        acceleration=felt,
        relative=relative,
        incidence=incidence_in_waves(felt.m0, felt.m2, hours, rao.g),
        dose=dose,
        dose_incidence=vomiting_by_dose(dose),
        wet=wet,
        slam=slam,
        wet_per_hour=None if wet is None else wet * waves,
        slams_per_hour=None if slam is None else slam * waves,
    )
