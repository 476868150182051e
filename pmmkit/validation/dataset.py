"""A comparison as one labelled set of data: runs, channels, harmonics or samples."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from pmmkit.conventions import CHANNEL_UNITS, METRICS
from pmmkit.inference import COVERAGE
from pmmkit.validation.captive import CaptiveRun
from pmmkit.validation.free_running import FreeRun, ManoeuvreComparison
from pmmkit.validation.uncertainty import OF_MEASUREMENT, SHARES

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


_OVER: Final = ("run", "channel", "harmonic")


def of_harmonics(runs: Sequence[CaptiveRun]) -> xr.Dataset:
    """Captive tests: what each harmonic of each force was, is predicted as, and may differ by."""
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
    """Free-running records: motion over the whole record, and forces through the smoother."""
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


# Comparison errors as workshops table them: E = D - S in per cent of D, beside U_D and U_V.


_COLUMNS: Final = (
    *("run", "test", "speed", "Fn", "channel", "unit", "harmonic", "D", "S"),
    *("E_percent", "U_D_percent", "U_V_percent", "within", "known"),
)
_MEASURES: Final = (
    *("run", "submitted_run", "test", "measure", "unit", "D", "S"),
    *("E_percent", "U_D_percent", "U_V_percent", "within"),
)


def errors_in_percent(runs: Sequence[CaptiveRun]) -> pd.DataFrame:
    """Comparison errors of captive tests in per cent of what was measured.

    Parameters
    ----------
    runs : sequence of CaptiveRun
        The runs of a comparison.

    Returns
    -------
    pandas.DataFrame
        A row per run, channel and harmonic: run, test, speed, Fn, channel, unit, harmonic, D
        (measured) and S (predicted) [N, N m], E_percent = 100 (D - S)/D, U_D_percent and
        U_V_percent (expanded, k = 2, over the size of D), within (whether D and S differ by no
        more than U_V), known. Where D is no larger than its own uncertainty with the floor it is
        no size to take a share of: there the per cents are NaN.

    Examples
    --------
    >>> import xarray as xr
    >>> from pmmkit.campaigns import Campaign, Run
    >>> from pmmkit.campaigns import Settings
    >>> from pmmkit.conventions import Ship, Water
    >>> from pmmkit.validation.submission import compare_submission
    >>> ship = Ship(name="m", L=4.0, B=1.0, d=0.25, volume=0.5, mass=500.0, Izz=500.0)
    >>> D, S = (
    ...     Campaign(title=title, ship=ship, water=Water(), runs=(
    ...         Run(id="SD_8", test="static_drift", kind="means", loader=lambda data=data: data,
    ...             settings=Settings(speed=1.0, drift=0.14)),))
    ...     for title, data in (("D", xr.Dataset({"Y": 80.0})), ("S", xr.Dataset({"Y": 84.0})))
    ... )
    >>> errors_in_percent(compare_submission(S, D).captive)[["channel", "D", "S", "E_percent"]]
      channel     D     S  E_percent
    0       Y  80.0  84.0       -5.0
    """
    data = of_harmonics(runs)
    std = data["standard_uncertainty"]
    own = COVERAGE * np.sqrt((std.sel(source=list(OF_MEASUREMENT)) ** 2).sum("source"))
    table = rows_of(data.assign(U_D=own, floor=COVERAGE * std.sel(source="floor", drop=True)))
    least = (table["U_D"] ** 2 + table["floor"] ** 2) ** 0.5
    return _in_percent(table, least)[[*_COLUMNS]]


def measures_in_percent(manoeuvres: Sequence[ManoeuvreComparison]) -> pd.DataFrame:
    """Measures of manoeuvres beside submitted ones, in per cent of what was measured.

    Parameters
    ----------
    manoeuvres : sequence of ManoeuvreComparison
        Of a comparison.

    Returns
    -------
    pandas.DataFrame
        A row per manoeuvre and measure, lengths in ship lengths: run, submitted_run, test, measure,
        unit, D (measured), S (submitted), and the other columns as for `errors_in_percent`.
    """
    import pandas as pd

    found = []
    for item in manoeuvres:
        chosen = METRICS.in_lengths(item.trial.metrics)
        for row in item.rows():
            if row["measure"] in chosen:
                own = COVERAGE * item.trial.std.get(row["measure"], np.nan)
                found.append({**row, "submitted_run": item.submitted_run, "U_D": own})
    if not found:
        return pd.DataFrame(columns=[*_MEASURES])
    table = pd.DataFrame(found)
    return _in_percent(table, table["U_D"])[[*_MEASURES]]


def _in_percent(table: pd.DataFrame, least: pd.Series) -> pd.DataFrame:
    """A table with its measured as D and predicted as S, in per cent of a D above `least`."""
    D, S, U_V = (table[name] for name in ("measured", "predicted", "uncertainty"))
    size = D.where(D.abs() > least)
    return table.assign(
        D=D,
        S=S,
        E_percent=100 * (D - S) / size,
        U_D_percent=100 * table["U_D"] / size.abs(),
        U_V_percent=100 * U_V / size.abs(),
        within=(D - S).abs() <= U_V,
    )
