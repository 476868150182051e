"""Comparison errors as workshops table them: E = D - S in per cent of D, beside U_D and U_V."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from pmmkit.validation.captive import CaptiveRun
from pmmkit.validation.free_running import FORCE_UNITS
from pmmkit.validation.uncertainty import COVERAGE

if TYPE_CHECKING:
    import pandas as pd


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
    import pandas as pd

    return pd.DataFrame(
        [row for run in runs for channel in run.channels for row in _rows(run, channel)]
    )


def _rows(run: CaptiveRun, channel: str) -> Iterator[dict[str, Any]]:
    own = run.view.run
    floor = COVERAGE * run.shares["floor"][channel]
    U_D, U_V = run.measurement_uncertainty(channel), run.uncertainty(channel)
    for place, label in enumerate(run.view.labels):
        D, S = float(run.view.force[channel][place]), float(run.predicted[channel][place])
        size = abs(D) if abs(D) > math.hypot(U_D[place], floor[place]) else math.nan
        yield {
            "run": own.id,
            "test": own.test,
            "speed": run.view.speed,
            "Fn": run.Fn,
            "channel": channel,
            "unit": FORCE_UNITS[channel],
            "harmonic": label,
            "D": D,
            "S": S,
            "E_percent": 100 * (D - S) / math.copysign(size, D),
            "U_D_percent": 100 * float(U_D[place]) / size,
            "U_V_percent": 100 * float(U_V[place]) / size,
            "within": bool(abs(D - S) <= U_V[place]),
            "known": run.view.known(channel),
        }
