"""Where a ship may be: bands of histories and paths of many ships with other derivatives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Final, Self

import numpy as np

from pmmkit.base import DataError, ModelError, SimulationError
from pmmkit.models import Model, load_model
from pmmkit.numerics import Array, turned
from pmmkit.simulation.ensemble import Batch, shared_out, strata, unstated
from pmmkit.simulation.kinds.catalogue import manoeuvre_of
from pmmkit.simulation.single import simulate, track_of
from pmmkit.simulation.spread import Draws, drawn_of
from pmmkit.simulation.track import Track

if TYPE_CHECKING:
    from pmmkit.plotting import Figure

DRAWN: Final = ("psi", "delta", "r", "u", "v")
"""Channels that have a band over time."""
PLACES: Final = 121
"""Headings of a circle at which its path has a band."""
LEAST: Final = 0.5
"""Share of the ships that must still be under way where a band is told."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Bands:
    """A manoeuvre with the central 95 % of ships that differ in their derivatives.

    Parameters
    ----------
    track : Track
        The model as it stands.
    low, high : mapping of str to array (m,)
        Ends of the band of each channel over the time of the track, SI and radians; NaN where
        fewer than half of the ships are still under way.
    inner, outer : array (k, 2)
        Edges of the band of the path [m], x ahead and y to starboard, by heading up to a full
        circle; empty where the ship does not turn through 30°.
    measures : mapping of str to (float, float)
        Central 95 % of the metrics.
    ships : int
        How many.
    """

    track: Track
    low: Mapping[str, Array]
    high: Mapping[str, Array]
    inner: Array
    outer: Array
    measures: Mapping[str, tuple[float, float]]
    ships: int
    SHIPS: ClassVar[int] = 200
    """Ships behind a band where their number is not given."""

    @classmethod
    def of(
        cls,
        model: Model | str | Path,
        manoeuvre: str = "turning",
        *,
        speed: float,
        n: int = SHIPS,
        spread: float | Draws | None = None,
        seed: int = 0,
        compiled: bool | None = None,
        extrapolate: bool = False,
        among: Sequence[tuple[Model, float]] = (),
        **settings: Any,
    ) -> Self:
        """Bands of a manoeuvre from ships drawn as for `monte_carlo`, the same by the same seed.

        Parameters
        ----------
        model, manoeuvre, speed, spread, seed, extrapolate, **settings
            As for `monte_carlo`.
        n : int
            Number of ships; each is kept in full, so some hundred.
        compiled : bool, optional
            As for `simulate`.
        among : sequence of (Model, float)
            Models that may each be the ship, with their odds: as many ships of each are drawn,
            about the track of `model`; one without covariance stands for all of its ships.

        Raises
        ------
        ModelError
            If the model has no covariance and `spread` is not given.
        DataError
            If an argument makes no sense, or no ship can be simulated.

        Examples
        --------
        >>> found = Bands.of("kvlcc2", rudder_deg=35, speed=7.97, n=20, spread=0.05)
        >>> low, high = found.measures["advance_L"]
        >>> low < found.track.metrics["advance_L"] < high
        True
        """
        if not (isinstance(n, int) and n > 1):
            raise DataError(f"n = {n} must be a whole number above 1.")
        loaded = model if isinstance(model, Model) else load_model(model)
        own: dict[str, Any] = {"speed": speed, "extrapolate": extrapolate, **settings}
        track = simulate(loaded, manoeuvre, compiled=compiled, **own)
        total = sum(odds for _, odds in among) or 1.0
        tracks: list[Track] = []
        for other, odds in among or ((loaded, 1.0),):
            count = max(round(n * odds / total), 1)
            differ = [item.name for item in unstated(manoeuvre_of(manoeuvre), settings)]
            if among and spread is None and not (differ or other.is_uncertain):
                tracks += [simulate(other, manoeuvre, compiled=compiled, **own)] * count
                continue
            batches = strata(other, manoeuvre, **own)
            batch = batches[0]
            drawn = drawn_of(
                batch.model, speed, spread, extrapolate=extrapolate, fn=batch.fn, beside=differ
            )
            tracks += [
                found
                for one, first, ships in shared_out(batches, count)
                for values in (drawn.draw(seed, first, ships) if ships else ())
                if (found := _sailed(one, drawn.names, values, settings, compiled=compiled))
            ]
        if not tracks:
            raise DataError("None of the ships can be simulated: give a smaller spread.")
        low, high = _over_time(track, tracks)
        inner, outer = _about(track, tracks)
        return cls(
            track=track,
            low=MappingProxyType(low),
            high=MappingProxyType(high),
            inner=inner,
            outer=outer,
            measures=MappingProxyType(
                {
                    name: _central(np.array([other.metrics[name] for other in tracks]))
                    for name in track.metrics
                }
            ),
            ships=len(tracks),
        )

    def figures(self) -> dict[str, Figure]:
        """The path of a turning circle with its band; every manoeuvre over time with its bands."""
        from pmmkit.plotting import band_histories, trajectory

        found = {}
        if len(self.inner):
            found["trajectory"] = trajectory([self.track], band=self)
        return found | {"histories": band_histories(self)}


def _sailed(
    batch: Batch,
    names: tuple[str, ...],
    values: Array,
    settings: Mapping[str, Any],
    *,
    compiled: bool | None,
) -> Track | None:
    """The track of one ship; None where its motion grows without bound."""
    ready = batch.ship(names, values)
    try:
        history = batch.history(ready, fast=compiled)
    except (SimulationError, ModelError):
        return None
    return track_of(batch.model, history, None, settings)


def _central(values: Array) -> tuple[float, float]:
    there = values[np.isfinite(values)]
    if not len(there):
        return np.nan, np.nan
    low, high = np.quantile(there, [0.025, 0.975])
    return float(low), float(high)


def _over_time(track: Track, tracks: list[Track]) -> tuple[dict[str, Array], dict[str, Array]]:
    """Ends of the band of each channel at the instants of a track."""
    low, high = {}, {}
    for channel in DRAWN:
        rows = np.stack(
            [np.interp(track.t, other.t, getattr(other, channel), right=np.nan) for other in tracks]
        )
        enough = np.isfinite(rows).mean(axis=0) >= LEAST
        ends = np.full((2, len(track.t)), np.nan)
        ends[:, enough] = np.nanquantile(rows[:, enough], [0.025, 0.975], axis=0)
        low[channel], high[channel] = ends
    return low, high


def _about(track: Track, tracks: list[Track]) -> tuple[Array, Array]:
    """Edges of the band of the path: quantiles across it of where ships are at like headings."""
    reach = min(float(turned(track.psi)[-1]), 2 * np.pi)
    none = np.empty((0, 2))
    if reach < np.pi / 6:
        return none, none
    headings = np.linspace(0.0, reach, PLACES)
    middle = _at(track, headings)
    along = np.gradient(middle, axis=0)
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    off = np.stack([np.sum((_at(other, headings) - middle) * across, axis=1) for other in tracks])
    kept = np.isfinite(off).mean(axis=0) >= LEAST
    low, high = np.nanquantile(off[:, kept], [0.025, 0.975], axis=0)
    middle, across = middle[kept], across[kept]
    return middle + low[:, None] * across, middle + high[:, None] * across


def _at(track: Track, headings: Array) -> Array:
    """Places x, y at changes of heading; NaN beyond the last."""
    reached = turned(track.psi)
    return np.stack(
        [np.interp(headings, reached, values, right=np.nan) for values in (track.x, track.y)],
        axis=1,
    )
