"""Comparison errors as workshops table them: E = D - S in per cent of D, beside U_D and U_V."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.inference import COVERAGE
from pmmkit.metrics import in_lengths
from pmmkit.validation.captive import CaptiveRun
from pmmkit.validation.dataset import of_harmonics, rows_of
from pmmkit.validation.manoeuvre import Manoeuvre
from pmmkit.validation.uncertainty import OF_MEASUREMENT

if TYPE_CHECKING:
    import pandas as pd

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
    >>> from pmmkit.campaigns.run import Campaign, Run
    >>> from pmmkit.campaigns.settings import Settings
    >>> from pmmkit.ship import Ship, Water
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


def measures_in_percent(manoeuvres: Sequence[Manoeuvre]) -> pd.DataFrame:
    """Measures of manoeuvres beside submitted ones, in per cent of what was measured.

    Parameters
    ----------
    manoeuvres : sequence of Manoeuvre
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
        chosen = in_lengths(item.trial.metrics)
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
