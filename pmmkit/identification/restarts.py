"""Filters that survive poor start values: what is tried, in turn, when the motion is lost."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final, Literal

import numpy as np

from pmmkit.base import DataError, Progress, SimulationError
from pmmkit.identification.binding import Binding, driven
from pmmkit.identification.filters import Filtered, kalman
from pmmkit.identification.prior import Prior
from pmmkit.identification.record import FreeRecord
from pmmkit.identification.trajectory import fit_trajectories
from pmmkit.models import Model
from pmmkit.numerics import precision_over

ROUGH: Final = 0.3
"""Process noise with which a filter that lost the motion begins anew."""
CLOSE: Final = 0.04
"""Variance with which an unscented filter begins anew, over the prior's: its points stay near."""


_Way = tuple[str, Sequence[FreeRecord], Prior, Mapping[str, Any]]
"""A way to begin: in words, the records in order, the prior, settings of the filter."""


def filtered(
    model: Model,
    records: Sequence[FreeRecord],
    prior: Prior,
    *,
    method: Literal["ekf", "ukf"],
    sensors: Mapping[str, float] | None = None,
    extrapolate: bool = False,
    progress: Progress | None = None,
    **settings: Any,
) -> tuple[Filtered, tuple[str, ...]]:
    """A Kalman filter that begins anew, in other ways, where it loses the motion."""
    tried: list[str] = []
    error = SimulationError("No way was tried.")
    for words, order, begun, changes in _ways(
        model, records, prior, method=method, sensors=sensors, extrapolate=extrapolate
    ):
        tried.append(words)
        try:
            found = kalman(
                model,
                order,
                begun,
                method=method,
                sensors=sensors,
                extrapolate=extrapolate,
                progress=progress,
                **{**changes, **settings},
            )
            if begun is not prior:
                found = _from(found, prior)
        except SimulationError as lost:
            error = lost
            continue
        return found, tuple(tried) if len(tried) > 1 else ()
    raise SimulationError(f"{error} Tried: {'; '.join(tried)}.") from error


def _ways(
    model: Model,
    records: Sequence[FreeRecord],
    prior: Prior,
    *,
    method: str,
    sensors: Mapping[str, float] | None,
    extrapolate: bool,
) -> Iterator[_Way]:
    """Ways to begin, the usual one first; each is worked out when it is asked for."""
    yield "from the start values", records, prior, {}
    mild = sorted(records, key=lambda item: float(np.std(item.delta)))
    rough: dict[str, Any] = {"first": ROUGH}
    yield "with larger unknown forces, the mildest record first", mild, prior, rough
    own = Binding.of(driven(model), prior.names, records[0].speed, extrapolate=extrapolate).mean
    about = {"the model's own values": own}
    try:
        fit = fit_trajectories(model, records, prior, sensors=sensors, extrapolate=extrapolate)
        about = {"the values of a fit through windows": fit.values, **about}
    except (SimulationError, DataError, np.linalg.LinAlgError):
        pass
    for words, values in about.items():
        near = replace(
            prior, mean=values, covariance=prior.covariance * (1.0 if method == "ekf" else CLOSE)
        )
        for step in (Binding.STEP, Binding.STEP / 4):
            yield f"from {words}, steps of {step:g} L/U", mild, near, {**rough, "step": step}


def _from(found: Filtered, prior: Prior) -> Filtered:
    """The result with the prior that counts in place of the one that the filter began with.

    The records add their information to either.
    """
    scale = prior.std
    both = np.outer(scale, scale)
    told, alone, begun, known = (
        precision_over(item, scale)
        for item in (found.covariance, found.lack.alone, found.prior.covariance, prior.covariance)
    )
    left = told - begun + known
    if np.linalg.eigvalsh(left)[0] <= 0.0:
        raise SimulationError("The filter tells less than the prior with which it began.")
    inverse = np.linalg.inv(left)
    score = told @ (found.values / scale) - begun @ (found.prior.mean / scale)
    covariance = inverse * both
    return replace(
        found,
        values=inverse @ (score + known @ (prior.mean / scale)) * scale,
        covariance=covariance,
        prior=prior,
        lack=replace(
            found.lack, covariance=covariance, alone=np.linalg.inv(alone - begun + known) * both
        ),
    )
