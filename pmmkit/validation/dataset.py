"""A comparison as one labelled set of data: runs, channels, harmonics or samples."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from pmmkit.channels import CHANNEL_UNITS
from pmmkit.inference import COVERAGE
from pmmkit.validation.captive import CaptiveRun
from pmmkit.validation.free_running import FreeRun
from pmmkit.validation.uncertainty import SHARES

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

_OVER: Final = ("run", "channel", "harmonic")


def of_harmonics(runs: Sequence[CaptiveRun]) -> xr.Dataset:
    """Captive tests: what each harmonic of each force was, is predicted as, and may differ by.

    Parameters
    ----------
    runs : sequence of CaptiveRun
        Of a comparison.

    Returns
    -------
    xarray.Dataset
        As `Comparison.to_xarray` describes it.
    """
    labels = _ordered(label for run in runs for label in run.view.labels)
    channels = _ordered(name for run in runs for name in run.channels)
    shape = (len(runs), len(channels), len(labels))
    measured, predicted = np.full(shape, np.nan), np.full(shape, np.nan)
    shares = np.full((len(SHARES), *shape), np.nan)
    known = np.zeros(shape[:2], bool)
    for i, run in enumerate(runs):
        at = [labels.index(label) for label in run.view.labels]
        for name in run.channels:
            j = channels.index(name)
            measured[i, j, at] = run.view.force[name]
            predicted[i, j, at] = run.predicted[name]
            shares[:, i, j, at] = [run.shares[source][name] for source in SHARES]
            known[i, j] = run.view.known(name)
    return _labelled(
        _OVER,
        measured,
        predicted,
        dict(zip(SHARES, shares, strict=True)),
        {
            "run": [run.view.run.id for run in runs],
            "channel": channels,
            "harmonic": labels,
            "test": ("run", [run.view.run.test for run in runs]),
            "speed": ("run", [run.view.speed for run in runs]),
            "Fn": ("run", [run.Fn for run in runs]),
            "known": (("run", "channel"), known),
        },
    )


def of_samples(runs: Sequence[FreeRun]) -> xr.Dataset:
    """Free-running records: motion over the whole record, and forces through the smoother.

    Parameters
    ----------
    runs : sequence of FreeRun
        Of a comparison.

    Returns
    -------
    xarray.Dataset
        As `Comparison.to_xarray` describes it; shorter records end in NaN.
    """
    channels = _ordered(name for run in runs for name in (*run.force, *run.measured))
    shape = (len(runs), len(channels), max(len(run.t) for run in runs))
    measured, predicted = np.full(shape, np.nan), np.full(shape, np.nan)
    sensors, model = np.full(shape, np.nan), np.full(shape, np.nan)
    instants = np.full((shape[0], shape[2]), np.nan)
    for i, run in enumerate(runs):
        count = len(run.t)
        instants[i, :count] = run.t
        for j, name in enumerate(channels):
            if name in run.force:
                measured[i, j, :count] = run.force[name]
                predicted[i, j, :count] = run.force_predicted[name]
                sensors[i, j, :count] = run.force_std[name]
                model[i, j, :count] = 0.0
            elif name in run.measured:
                measured[i, j, :count] = run.measured[name]
                predicted[i, j, :count] = run.predicted[name]
                sensors[i, j, :count] = run.std[name]
                model[i, j, :count] = run.predicted_std[name]
    return _labelled(
        ("run", "channel", "sample"),
        measured,
        predicted,
        {"measurement": sensors, "prediction": model},
        {
            "run": [run.name for run in runs],
            "channel": channels,
            "t": (("run", "sample"), instants, {"units": "s"}),
            "test": ("run", [run.run.test for run in runs]),
            "speed": ("run", [run.run.settings.speed for run in runs]),
            "Fn": ("run", [run.Fn for run in runs]),
        },
    )


def rows_of(data: xr.Dataset) -> pd.DataFrame:
    """A row per run, channel and harmonic that was measured, of `of_harmonics`."""
    table = data.drop_dims("source").to_dataframe(list(_OVER)).reset_index()
    return table.dropna(subset="measured").reset_index(drop=True)


def _ordered(names: Iterable[str]) -> list[str]:
    return list(dict.fromkeys(names))


def _labelled(
    over: tuple[str, str, str],
    measured: Any,
    predicted: Any,
    sources: dict[str, Any],
    coords: dict[str, Any],
) -> xr.Dataset:
    import xarray as xr

    std = np.stack(list(sources.values()))
    # Sum of a list, not of an axis: to the bit what `CaptiveRun.uncertainty` says.
    total = COVERAGE * np.sqrt(np.sum([x**2 for x in std], axis=0))
    units = [CHANNEL_UNITS[name] for name in coords["channel"]]
    return xr.Dataset(
        {
            "measured": (over, measured),
            "predicted": (over, predicted),
            "error": (over, predicted - measured),
            "uncertainty": (over, total),
            "standard_uncertainty": (("source", *over), std),
        },
        coords={**coords, "unit": ("channel", units), "source": list(sources)},
    )
