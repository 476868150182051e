"""The sea of a manoeuvre, as it is typed."""

from __future__ import annotations

from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from pmmkit.models.model import Model
    from pmmkit.seakeeping import Hull, MotionInWaves, Sea
    from pmmkit.simulation.track import Track


def stated_sea(height: float | None, period: float | None, *, wave_motion: bool) -> Sea | None:
    """The sea of ``--wave-height`` and ``--wave-period``; None where a period is not stated."""
    if height is None and (period is not None or wave_motion):
        raise typer.BadParameter("Waves need a height: write --wave-height 3 --wave-period 8.")
    if wave_motion and period is None:
        raise typer.BadParameter("--wave-motion needs --wave-period, the peak period in s.")
    if height is None or period is None:
        return None
    from pmmkit.seakeeping import sea

    return sea("bretschneider", Hs=height, Tp=period)


def carried(model: Model, sea: Sea | None, name: str, speed: float, from_deg: float) -> Model:
    """A model with the drift of a sea, by strip theory; its own where it has one."""
    from pmmkit.models.roles import parts_of

    if sea is None or parts_of(model, "waves"):
        return model
    from pmmkit.seakeeping import in_waves

    return in_waves(model, sea, speed=speed, from_deg=from_deg, hull=_hull(model, name))


def first_order(
    track: Track, model: Model, sea: Sea, name: str, from_deg: float, seed: int
) -> MotionInWaves:
    """Motions at the frequency of the waves along a track."""
    import numpy as np

    from pmmkit.seakeeping import frequencies, rao, superposed

    hull = _hull(model, name)
    found = rao(
        hull,
        speeds=[0.0, track.speed],
        headings_deg=np.arange(0, 181, 10),
        omega=frequencies(hull.L, sea),
        rho=model.water.rho,
        g=model.water.g,
    )
    return superposed(track, found, sea, from_deg=from_deg, seed=seed)


def _hull(model: Model, name: str) -> Hull:
    """The hull of the library that has the model's name, else sections from its particulars."""
    from pmmkit.seakeeping import hull_of, hulls, load_hull

    return load_hull(name) if name in hulls() else hull_of(model.ship)
