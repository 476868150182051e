"""Where each number of a model stands in the flat list of its constants."""

from __future__ import annotations

from typing import Final

NAMES: Final = (
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
)
"""The numbers that every model has; those of its effects follow from `FIRST` on. The engine knows
their places; the mass of surge and the inverse of the mass matrix of sway, yaw and roll (i11 to
i33) are filled in by it. More forces [N, N m] than those of the effects are zero but in a filter
that looks for what the effects lack."""
PLACE: Final = {name: place for place, name in enumerate(NAMES)}
FIRST: Final = len(NAMES)
STATES: Final = ("x", "y", "psi", "u", "v", "r")
ROLLING: Final = ("p", "phi")
"""States of the ship; those of effects follow."""
