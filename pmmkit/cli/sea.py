"""The sea of a manoeuvre, as it is typed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from pmmkit.models.model import Model
    from pmmkit.seakeeping import Hull, MotionInWaves, Sea
    from pmmkit.simulation.track import Track

WaveHeight = Annotated[
    float | None,
    typer.Option(help="Significant height of waves in m, whose mean drift carries the ship."),
]
WavePeriod = Annotated[
    float | None,
    typer.Option(help="Their peak period in s, from which strip theory finds the forces."),
]
WAVES = "Waves need a height and a peak period: write --wave-height 3 --wave-period 8."


def stated_sea(height: float | None, period: float | None) -> Sea | None:
    """The sea of ``--wave-height`` and ``--wave-period``; None where both are absent."""
    if height is None and period is None:
        return None
    if height is None or period is None:
        raise typer.BadParameter(WAVES)
    from pmmkit.seakeeping import sea

    return sea("bretschneider", Hs=height, Tp=period)


def carried(model: Model, sea: Sea | None, name: str, speed: float, from_deg: float) -> Model:
    """A model that feels the mean drift of a sea: by its own table, else by strip theory."""
    from pmmkit.models.roles import parts_of

    if sea is None:
        return model
    own = parts_of(model, "waves")
    if own:
        return model.with_values(own[0], Hs=sea.Hs, from_deg=from_deg)
    from pmmkit.seakeeping import in_waves

    return in_waves(model, sea, speed=speed, from_deg=from_deg, hull=_hull(model, name))


def first_order(
    track: Track, model: Model, sea: Sea, name: str, from_deg: float, seed: int
) -> MotionInWaves:
    """Motions at the frequency of the waves along a track."""
    from pmmkit.seakeeping import frequencies, rao, superposed

    hull = _hull(model, name)
    found = rao(
        hull,
        speeds=[0.0, track.speed],
        headings_deg=range(0, 181, 10),
        omega=frequencies(hull.L, sea),
        rho=model.water.rho,
        g=model.water.g,
    )
    return superposed(track, found, sea, from_deg=from_deg, seed=seed)


def new_notes(model: Model, before: Model) -> list[str]:
    """What a model has to say beyond what it said before."""
    return [f"note: {text}" for text in model.notes if text not in before.notes]


def _hull(model: Model, name: str) -> Hull:
    """The hull of the library with the model's name and size, else its particulars' sections."""
    from pmmkit.seakeeping import hull_of, hulls, load_hull

    known = load_hull(name) if name in hulls() else None
    return known if known is not None and known.L == model.ship.L else hull_of(model.ship)
