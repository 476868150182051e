"""The sea of a manoeuvre, as it is typed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from pmmkit.actions.setting import SettingError, setting, settings
from pmmkit.actions.speeds import typed_list

if TYPE_CHECKING:
    from pmmkit.models import Model
    from pmmkit.seakeeping import MotionInWaves, Rao, Sea
    from pmmkit.simulation import Track

WAVES = "Waves need a height and a peak period: write --wave-height 3 --wave-period 8."


@settings
class WaveSettings:
    """Waves."""

    wave_height: float | None = setting(
        "Significant height of waves in m, whose mean drift carries the ship.", default=None
    )
    wave_period: float | None = setting(
        "Their peak period in s, from which strip theory finds the forces.", default=None
    )
    waves_from_deg: float = setting(
        "Where they come from, from where the heading is zero.", default=0.0
    )
    wave_speeds: str | None = setting(
        "Speeds of the ship at which the drift is found, such as '0,8,15 kn'; if absent at "
        "rest and that of the approach.",
        default=None,
    )

    @property
    def sea(self) -> Sea | None:
        """The sea; None in a calm."""
        if self.wave_height is None and self.wave_period is None:
            return None
        if self.wave_height is None or self.wave_period is None:
            raise SettingError(WAVES)
        from pmmkit.seakeeping import sea

        return sea("bretschneider", Hs=self.wave_height, Tp=self.wave_period)


def carried(
    model: Model, waves: WaveSettings, name: str, speed: float
) -> tuple[Model, Rao | None, tuple[str, ...]]:
    """A model that feels the mean drift of a sea: by its own table, else by strip theory.

    With the motions from which the drift was found, where the model has no table of its own, and
    what there is to say of the sea. The model itself in a calm; speed [m/s].
    """
    from pmmkit.identification import other_period

    sea, speeds, from_deg = waves.sea, waves.wave_speeds, waves.waves_from_deg
    if sea is None:
        if speeds is not None:
            raise SettingError(WAVES)
        return model, None, ()
    own = model.in_role("waves")
    if own:
        if speeds is not None:
            raise SettingError("The model has its table of drift: leave --wave-speeds out.")
        told = other_period(model, [sea.Tp], "this sea has")
        rough = model.with_values(own[0], Hs=sea.Hs, from_deg=from_deg)
        return rough, None, (told,) if told else ()
    from pmmkit.seakeeping import in_waves

    motions = _motions(model, sea, name, _table(speeds, model) or speed)
    return in_waves(model, sea, motions=motions, from_deg=from_deg), motions, ()


def first_order(
    track: Track, rough: Model, motions: Rao | None, sea: Sea, name: str, from_deg: float, seed: int
) -> MotionInWaves:
    """Motions at the frequency of the waves along a track."""
    from pmmkit.seakeeping import superposed

    found = motions or _motions(rough, sea, name, track.speed)
    return superposed(track, found, sea, from_deg=from_deg, seed=seed)


def _motions(model: Model, sea: Sea, name: str, speed: float | Sequence[float]) -> Rao:
    from pmmkit.seakeeping import motions_in

    return motions_in(model, sea, speed=speed, hull=name)


def _table(speeds: str | None, model: Model) -> list[float]:
    typed = typed_list(speeds) if speeds is not None else ()
    return [item.of(model.ship, model.water) for item in typed]


def new_notes(rough: Model, of_sea: Sequence[str], before: Model) -> list[str]:
    """What a model in a sea has to say beyond what it said in a calm."""
    fresh = [text for text in rough.notes if text not in before.notes]
    return [f"note: {text}" for text in (*fresh, *of_sea)]
