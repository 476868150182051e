"""What is hidden in a campaign: each size is zero where nothing is."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Hidden:
    """Departures of the ship, her surroundings and her instruments from the model of a user.

    Parameters
    ----------
    heel : float
        Share of the terms of heel and roll rate that sway, yaw and surge feel; of a ship that
        rolls.
    side, turn : float
        Constant side force and moment over ½ρL²U² and ½ρL³U².
    vvr, vrr : (float, float)
        What comes to the products v'v'r' and v'r'r' in side force and moment, over the same.
    vr : float
        What comes to the product v'r' in the surge force.
    plate : float
        Drag coefficient of the hull's lateral area in sway alone; it acts 0.2 L behind midship.
    ends : float
        Drag coefficient of the strips that yaw alone moves; larger at the stern.
    strips : float
        Drag coefficient of strips in sway and yaw together.
    bottom : float
        Square of draught over depth: the linear forces of sway and yaw grow with it.
    late_side, late_turn : float
        Part of the derivatives of v' that is late by `lag` [L/U].
    lag : float
    resistance : float
        Share by which the resistance is larger.
    wake, deduction : float
        Added to wake fraction and thrust deduction.
    drift_wake : float
        Added to what says how the inflow of the propeller grows in drift.
    straightening, crossing : float
        Added to the flow straightening, and to the part of the yaw rate in the cross flow.
    hull_share, hull_point, steering_drag : float
        Added to aH, xH and tR.
    stalled : float
        Share of a rudder whose lift falls beyond its stall angle, in place of one that never does.
    windage : float
        Share of the areas above water; 1 is the ship's, 0 a calm.
    waves : float
        Share of the mean force of the sea; 1 is that of `flow.wave_forces`, 0 a calm.
    current : (float, float)
        Velocity of the water along the first heading, and to starboard of it [m/s].
    rudder_zero : float
        The rudder stands so much further to starboard than its column says [rad].
    play : float
        The blade follows its stock, which the column shows, only where the two are so far apart
        [rad].
    bank : float
        Suction of a bank five lengths to starboard of the approach, over ½ρL²U²; it grows as the
        ship comes near, and pushes the bow away.
    tether : float
        Pull of a line from the stern to where the record begins, over ½ρL²U².
    ventilated : float
        Share of its lift that a rudder loses on one side, where air is drawn down to it.
    late_positions : float
        Positions carry the time of so much later [s].
    antenna : float
        The antenna of the positions, forward of midship [m].
    heading_offset : float
        The column of the heading shows so much more [rad].
    log_gain : float
        Share by which the log shows more.
    """

    heel: float = 1.0
    side: float = 0.0
    turn: float = 0.0
    vvr: tuple[float, float] = (0.0, 0.0)
    vrr: tuple[float, float] = (0.0, 0.0)
    vr: float = 0.0
    plate: float = 0.0
    ends: float = 0.0
    strips: float = 0.0
    bottom: float = 0.0
    late_side: float = 0.0
    late_turn: float = 0.0
    lag: float = 1.5
    resistance: float = 0.0
    wake: float = 0.0
    deduction: float = 0.0
    drift_wake: float = 0.0
    straightening: float = 0.0
    crossing: float = 0.0
    hull_share: float = 0.0
    hull_point: float = 0.0
    steering_drag: float = 0.0
    stalled: float = 0.0
    windage: float = 0.0
    waves: float = 0.0
    current: tuple[float, float] = (0.0, 0.0)
    rudder_zero: float = 0.0
    play: float = 0.0
    bank: float = 0.0
    tether: float = 0.0
    ventilated: float = 0.0
    late_positions: float = 0.0
    antenna: float = 0.0
    heading_offset: float = 0.0
    log_gain: float = 0.0


NOTHING = Hidden()
