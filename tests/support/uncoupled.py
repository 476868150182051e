"""A ship of the library that lacks an effect."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType

from pmmkit.models import Model, load_model


def uncoupled() -> Model:
    """Son and Nomoto's ship without its terms of sway and yaw together."""
    ship = load_model("s175-3dof")
    hull = ship.parts["hull_polynomial"]
    kept = {k: v for k, v in hull.values.items() if k not in ("Yvvr", "Yvrr", "Nvvr", "Nvrr")}
    changed = replace(hull, values=MappingProxyType(kept))
    return ship.with_(parts=MappingProxyType({**ship.parts, "hull_polynomial": changed}))
