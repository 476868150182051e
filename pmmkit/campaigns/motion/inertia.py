"""From what the balance says to the force of the water on the hull, at midship."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from pmmkit.campaigns.run import Campaign, Run
from pmmkit.effects import State
from pmmkit.numerics import Array


@dataclass(frozen=True, kw_only=True)
class Rig:
    """Inertia and reference points that turn a reading into the force of the water.

    Parameters
    ----------
    mass, Izz, xG : float
        What oscillates below the balance: mass [kg], yaw inertia about midship [kg m²],
        centre of gravity forward of midship [m].
    zG, Ixx : float
        Centre of gravity below the origin [m], roll inertia [kg m²]; zero where not stated.
    moment_x, moment_z : float
        Point to which the measured moments refer, from midship [m].
    motion_x : float
        Point to which the motion refers, forward of midship [m].
    """

    mass: float
    Izz: float
    xG: float
    zG: float
    Ixx: float
    moment_x: float
    moment_z: float
    motion_x: float


def rig_of(campaign: Campaign) -> Rig:
    """The rig that a campaign states; the dry mass on the balance counts before the ship's."""
    ship = campaign.ship
    return Rig(
        mass=ship.mass if ship.balance_mass is None else ship.balance_mass,
        Izz=ship.Izz if ship.balance_Izz is None else ship.balance_Izz,
        xG=ship.xG if ship.balance_xG is None else ship.balance_xG,
        zG=ship.zG or 0.0,
        Ixx=ship.Ixx or 0.0,
        moment_x=campaign.moment_reference_x,
        moment_z=campaign.moment_reference_z,
        motion_x=campaign.motion_reference_x,
    )


def inertia_force(motion: State, rig: Rig) -> dict[str, Array]:
    """Mass times acceleration of the model about midship, channel by channel.

    X: m(u̇ - rv - xG r²), Y: m(v̇ + ru + xG ṙ), N: Izz ṙ + m xG(v̇ + ru),
    K: Ixx ṗ - m zG(v̇ + ru).

    Parameters
    ----------
    motion : State
        Motion of midship.
    rig : Rig
        What oscillates.

    Returns
    -------
    dict of str to array (n,)
        Forces [N] and moments [N m].

    Examples
    --------
    >>> rig = Rig(mass=2.0, Izz=3.0, xG=0.5, zG=0.0, Ixx=0.0, moment_x=0, moment_z=0, motion_x=0)
    >>> float(inertia_force(State.of(u=1.0, r=0.1, rdot=1.0), rig)["N"][0])
    3.1
    """
    sway = motion.vdot + motion.r * motion.u
    return {
        "X": rig.mass * (motion.udot - motion.r * motion.v - rig.xG * motion.r**2),
        "Y": rig.mass * (sway + rig.xG * motion.rdot),
        "N": rig.Izz * motion.rdot + rig.mass * rig.xG * sway,
        "K": rig.Ixx * motion.pdot - rig.mass * rig.zG * sway,
    }


def inertia_inside(run: Run, motion: State, rig: Rig) -> dict[str, Array]:
    """The inertia that the balance feels, zero where the forces are those of the water alone.

    Parameters
    ----------
    run, rig : Run, Rig
        What oscillates.
    motion : State
        Of midship.
    """
    inertia = inertia_force(motion, rig)
    if run.forces == "balance":
        return inertia
    return {name: np.zeros_like(x) for name, x in inertia.items()}


def force_of_water(
    read: Mapping[str, Array],
    run: Run,
    motion: State,
    rig: Rig,
    project: Callable[[Array], Array] = np.asarray,
) -> dict[str, Array]:
    """Forces of the water at midship from what was read.

    Parameters
    ----------
    read : mapping of channel to array
        Samples or harmonics as measured [N, N m].
    run, rig : Run, Rig
        What oscillates, and whether its inertia is inside.
    motion : State
        Of midship at the samples.
    project : callable
        From samples to what `read` holds.
    """
    force = at_midship(read, rig)
    if run.forces == "hydrodynamic":
        return force
    inertia = inertia_force(motion, rig)
    return {name: x + project(inertia[name]) for name, x in force.items()}


def as_read(
    force: Mapping[str, Array],
    run: Run,
    motion: State,
    rig: Rig,
    project: Callable[[Array], Array] = np.asarray,
) -> dict[str, Array]:
    """What was read, from the forces of the water at midship: undoes `force_of_water`."""
    inside = inertia_inside(run, motion, rig)
    read = {name: x - project(inside[name]) for name, x in force.items()}
    more = moments_of_sway(read["Y"], rig) if "Y" in read else {}
    return {name: x - more[name] if name in more else x for name, x in read.items()}


def at_midship(force: Mapping[str, Array], rig: Rig) -> dict[str, Array]:
    """Moments moved from their reference point to midship: N + x Y, K - z Y."""
    if "Y" not in force:
        return dict(force)
    more = moments_of_sway(force["Y"], rig)
    return {name: x + more[name] if name in more else x for name, x in force.items()}


def moments_of_sway(force: Array, rig: Rig) -> dict[str, Array]:
    """Moments about midship of a sway force at the point of the moments, where they differ.

    Parameters
    ----------
    force : array
        Sway force, any shape [N].
    rig : Rig
        Its `moment_x`, `moment_z` are used.
    """
    arms = {"N": rig.moment_x, "K": -rig.moment_z}
    return {name: arm * force for name, arm in arms.items() if arm}
