"""From what the balance says to the force of the water on the hull, at midship."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from pmmkit.campaigns.stated_run import StatedRun
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

    def inertia_force(self, motion: State) -> dict[str, Array]:
        """Mass times acceleration of the model about midship, channel by channel.

        X: m(u̇ - rv - xG r²), Y: m(v̇ + ru + xG ṙ), N: Izz ṙ + m xG(v̇ + ru),
        K: Ixx ṗ - m zG(v̇ + ru).

        Parameters
        ----------
        motion : State
            Motion of midship.

        Returns
        -------
        dict of str to array (n,)
            Forces [N] and moments [N m].

        Examples
        --------
        >>> rig = Rig(mass=2., Izz=3., xG=0.5, zG=0., Ixx=0., moment_x=0, moment_z=0, motion_x=0)
        >>> float(rig.inertia_force(State.of(u=1.0, r=0.1, rdot=1.0))["N"][0])
        3.1
        """
        sway = motion.vdot + motion.r * motion.u
        return {
            "X": self.mass * (motion.udot - motion.r * motion.v - self.xG * motion.r**2),
            "Y": self.mass * (sway + self.xG * motion.rdot),
            "N": self.Izz * motion.rdot + self.mass * self.xG * sway,
            "K": self.Ixx * motion.pdot - self.mass * self.zG * sway,
        }

    def inertia_inside(self, run: StatedRun, motion: State) -> dict[str, Array]:
        """The inertia that the balance feels, zero where the forces are those of the water alone.

        motion of midship.
        """
        inertia = self.inertia_force(motion)
        if run.forces == "balance":
            return inertia
        return {name: np.zeros_like(x) for name, x in inertia.items()}

    def force_of_water(
        self,
        read: Mapping[str, Array],
        run: StatedRun,
        motion: State,
        project: Callable[[Array], Array] = np.asarray,
    ) -> dict[str, Array]:
        """Forces of the water at midship from what was read.

        Parameters
        ----------
        read : mapping of channel to array
            Samples or harmonics as measured [N, N m].
        run : StatedRun
            Says whether the inertia is inside.
        motion : State
            Of midship at the samples.
        project : callable
            From samples to what `read` holds.
        """
        more = self.moments_of_sway(read["Y"]) if "Y" in read else {}
        force = {name: x + more[name] if name in more else x for name, x in read.items()}
        if run.forces == "hydrodynamic":
            return force
        inertia = self.inertia_force(motion)
        return {name: x + project(inertia[name]) for name, x in force.items()}

    def as_read(
        self,
        force: Mapping[str, Array],
        run: StatedRun,
        motion: State,
        project: Callable[[Array], Array] = np.asarray,
    ) -> dict[str, Array]:
        """What was read, from the forces of the water at midship: undoes `force_of_water`."""
        inside = self.inertia_inside(run, motion)
        read = {name: x - project(inside[name]) for name, x in force.items()}
        more = self.moments_of_sway(read["Y"]) if "Y" in read else {}
        return {name: x - more[name] if name in more else x for name, x in read.items()}

    def moments_of_sway(self, force: Array) -> dict[str, Array]:
        """Moments about midship of a sway force [N] at the point of the moments, where they differ.

        N + x Y, K - z Y.
        """
        arms = {"N": self.moment_x, "K": -self.moment_z}
        return {name: arm * force for name, arm in arms.items() if arm}
