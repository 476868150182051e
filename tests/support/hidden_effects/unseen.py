"""Six more effects that stand in no catalogue, made before the rules that judge them: no bound of
the diagnosis was set with these."""

from __future__ import annotations

import numpy as np

from .catalogue import Source
from .hull import Force, hull_force, prime
from .motion import Motion
from .sizes import SHIP, scale


def unseen_shed_vortices(m: Motion) -> Force:
    """Vortices that the hull sheds in drift at a Strouhal number of 0.2 on half its length; each
    run has a phase of its own."""
    phase = 1.7 * sum(map(ord, m.plan.id))
    beat = np.cos(2 * np.pi * 0.2 * m.carriage / (0.5 * SHIP.L) * m.t + phase)
    return prime(m, Y=0.008 * m.vp**2 * beat, N=-0.0027 * m.vp**2 * beat)


def unseen_umbilical(m: Motion) -> Force:
    """Cables to the carriage that resist the heading of the model, as a spring; in newtons."""
    turned = np.sin(m.psi)
    return {"Y": -14.0 * turned, "N": -18.0 * turned}


def unseen_ventilated_strut(m: Motion) -> Force:
    """A wetted strut at the bow that lifts with the sidewash until it ventilates at 6°."""
    sidewash = m.vp + 0.42 * m.rp
    lift = sidewash * np.where(abs(sidewash) < np.radians(6.0), 1.0, 0.35)
    return prime(m, Y=-0.0012 * lift, N=-0.42 * 0.0012 * lift)


def unseen_seiche(m: Motion) -> Force:
    """The long standing wave of the tank: water that flows along it, another way in each run."""
    flow = 0.02 * np.cos(2.9 * sum(map(ord, m.plan.id)))
    drag = hull_force(m)
    return {name: 2.0 * flow / m.carriage * force for name, force in drag.items()}


def unseen_coarse_digits(m: Motion) -> Force:
    """An amplifier at the wrong range: Y in steps of a twelfth of its usual force."""
    step = scale("Y") / 12.0
    Y = hull_force(m)["Y"]
    return {"Y": step * np.round(Y / step) - Y}


def unseen_breaking_bow(m: Motion) -> Force:
    """A bow wave that breaks where the sidewash at the bow is large: drag, and lift that is lost;
    above a Froude number of 0.2 alone."""
    if m.froude < 0.2:
        return {}
    over = np.maximum(abs(m.vp + 0.45 * m.rp) - 0.1, 0.0) * np.sign(m.vp + 0.45 * m.rp)
    return prime(m, X=-0.0012 * abs(over), Y=0.0014 * over, N=0.45 * 0.0014 * over)


FORCES: dict[str, Source] = {
    function.__name__: function
    for function in (
        unseen_shed_vortices,
        unseen_umbilical,
        unseen_ventilated_strut,
        unseen_seiche,
        unseen_coarse_digits,
        unseen_breaking_bow,
    )
}
