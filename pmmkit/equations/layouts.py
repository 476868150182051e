"""Where each number stands in the flat lists of the equations, and the numbers of kinds.

The one place that says it: those who fill a list and those who read it use these names. The
functions of `pmmkit.equations.integrator` and its neighbours write them too;
`pmmkit.equations.code_generation` puts their numbers into the text of a module, so that
a name costs nothing there and a module made for other layouts is another module.
"""

from __future__ import annotations

from enum import IntEnum
from typing import Final

Constant = IntEnum(
    "Constant",
    (
        "L",
        "B",
        "d",
        "mass",
        "volume",
        "GM",
        "rho",
        "g",
        "xG",
        "zG",
        "Izz",
        "Ixx",
        "rolls",
        "Xudot",
        "Yvdot",
        "Yrdot",
        "Ypdot",
        "Nvdot",
        "Nrdot",
        "Npdot",
        "Kvdot",
        "Krdot",
        "Kpdot",
        "coriolis_x",
        "coriolis_y",
        "coriolis_k",
        "surge_mass",
        "i11",
        "i12",
        "i13",
        "i21",
        "i22",
        "i23",
        "i31",
        "i32",
        "i33",
        "reference",
        "square",
        "loss_from",
        "wind_speed",
        "wind_direction",
        "depth",
        "current_x",
        "current_y",
        "speed",
        "more_X",
        "more_Y",
        "more_N",
        "more_K",
        "roll",
        "roll_rate",
        "roll_acceleration",
        "wave_height",
        "wave_direction",
    ),
    start=0,
)
"""The constants ``k`` that every model has; those of its effects follow. The engine fills in the
mass of surge and the inverse of the mass matrix of sway, yaw and roll (i11 to i33). More forces
[N, N m] than those of the effects are zero but in a filter that looks for what the effects lack.
Heel [rad], roll rate [rad/s] and its rate [rad/s²] are those measured, where estimators drive a
ship that does not roll by itself. Wave height [m] and direction [rad] are those that a record
states; a height below zero where none does, and the model has a sea of its own or none."""

State = IntEnum("State", ("x", "y", "psi", "u", "v", "r", "p", "phi"), start=0)
"""The states of a ship; of one that does not roll those up to r. States of effects follow."""
ROLLING: Final = (State.p.name, State.phi.name)
STATES: Final = tuple(state.name for state in State if state.name not in ROLLING)

Control = IntEnum("Control", ("rudder", "revolutions", "bucket"), start=0)
"""Where a layout below has a place for each control, the three lie side by side in this order."""
GearField = IntEnum("GearField", ("since", "start", "order", "rate", "lag"), start=0)
"""How a control follows its order; one after another for the controls in ``gear``."""

PhaseField = IntEnum(
    "PhaseField",
    ("rudder", "revolutions", "bucket", "until", "level", "side", "shortest", "longest"),
    start=0,
)
"""A phase of a manoeuvre in ``phases``: orders to the controls, and what ends it."""
End = IntEnum("End", ("time", "heading", "yaw_rate", "surge", "steady_turn", "steady"), start=0)
"""What ends a phase."""

ProbeField = IntEnum("ProbeField", ("ask", "state", "level", "side", "first", "last"), start=0)
"""A question to a history in ``probes``."""
Ask = IntEnum("Ask", ("crossing", "extreme", "end", "begin", "path", "steady", "reached"), start=0)
"""What a probe asks."""

SettingField = IntEnum(
    "SettingField",
    (
        "rtol",
        "longest",
        "speed",
        "rudder_rate",
        "revolutions_rate",
        "bucket_rate",
        "rudder_lag",
        "revolutions_lag",
        "bucket_lag",
        "revolutions",
        "fastest",
    ),
    start=0,
)
"""Settings of the integrator; revolutions are those of the approach, 0 for self-propulsion without
waves, below 0 for self-propulsion in them."""
StepField = IntEnum("StepField", ("begin", "length"), start=0)
"""What a kept step begins with; the states and four coefficients for each follow."""
EventField = IntEnum(
    "EventField",
    (
        "begin",
        "rudder",
        "revolutions",
        "bucket",
        "rudder_order",
        "revolutions_order",
        "bucket_order",
        "step",
        "finished",
    ),
    start=0,
)
"""What is known of the begin of a phase in ``events``: the instant, the controls and their orders,
the number of the first step, and whether what it waited for ended it. One more row has the end."""
Status = IntEnum(
    "Status", ("done", "mass", "unbound", "small_steps", "no_room", "no_propulsion"), start=0
)
"""How an integration ended."""
OutcomeField = IntEnum("OutcomeField", ("status", "revolutions"), start=0)
"""What is told of each of many ships."""
CourseField = IntEnum(
    "CourseField",
    (
        "t",
        "h",
        "before",
        "kept",
        "status",
        "revolutions",
        "phase",
        "opened",
        "since",
        "end",
        "level",
        "more",
        "past",
        "ahead",
        "stop",
        "clipped",
        "exact",
        "lost",
    ),
    start=0,
)
"""How far a ship has come in its phases: the instant, the next step, the error of the last, the
number of kept steps, a `Status`, the revolutions of the approach; the phase, whether it is open,
when it may end and must end, the level it waits for, how often more it may wait for a steady turn,
whether the first instant is past and how far the level is passed, where the next step must end and
whether that clips it, the length of a step that ends exactly at the level, and whether a phase was
lost, after which none is sailed."""
LaneSlot = IntEnum(
    "LaneSlot",
    ("y", "z", "rate", "k1", "k2", "k3", "k4", "k5", "k6", "k7", "size", "error", "length"),
    start=0,
)
"""What lanes have of each state, side by side, k1 to k7 one after another; the length of the step
stands there once a state. Behind it follow the instants, a `LaneMove` of each control and the
constants, so that all lie in one list: of several a compiler would not know that they are apart."""
LaneMove = IntEnum(
    "LaneMove", ("since", "start", "order", "pace", "ramp", "rest", "lag", "value"), start=0
)
"""How a control of each lane moves: its signed rate, how long it
holds that, and what is left for the lag."""

InputField = IntEnum(
    "InputField",
    (
        "rudder",
        "revolutions",
        "bucket",
        "wind_speed",
        "wind_direction",
        "wave_height",
        "wave_direction",
        "roll",
        "roll_rate",
        "roll_acceleration",
    ),
    start=0,
)
"""A row of the inputs of a filter; a ship that rolls by itself does not look at the last three."""
OverGround = IntEnum("OverGround", ("north", "east", "size"), start=100)
"""Kinds of measured columns beside the states, which are known by their places: the velocity over
ground and its size."""
