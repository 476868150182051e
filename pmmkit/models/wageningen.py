"""Open-water curves of the Wageningen B series, by its polynomials.

Source: Oosterveld, M. W. C., van Oossanen, P. (1975), Further computer-analyzed data of the
Wageningen B-screw series, International Shipbuilding Progress 22(251), at Re = 2·10⁶.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from pmmkit.base import DataError
from pmmkit.numerics import Array

THRUST: Final = (
    (0.00880496, 0, 0, 0, 0), (-0.204554, 1, 0, 0, 0), (0.166351, 0, 1, 0, 0),
    (0.158114, 0, 2, 0, 0), (-0.147581, 2, 0, 1, 0), (-0.481497, 1, 1, 1, 0),
    (0.415437, 0, 2, 1, 0), (0.0144043, 0, 0, 0, 1), (-0.0530054, 2, 0, 0, 1),
    (0.0143481, 0, 1, 0, 1), (0.0606826, 1, 1, 0, 1), (-0.0125894, 0, 0, 1, 1),
    (0.0109689, 1, 0, 1, 1), (-0.133698, 0, 3, 0, 0), (0.00638407, 0, 6, 0, 0),
    (-0.00132718, 2, 6, 0, 0), (0.168496, 3, 0, 1, 0), (-0.0507214, 0, 0, 2, 0),
    (0.0854559, 2, 0, 2, 0), (-0.0504475, 3, 0, 2, 0), (0.010465, 1, 6, 2, 0),
    (-0.00648272, 2, 6, 2, 0), (-0.00841728, 0, 3, 0, 1), (0.0168424, 1, 3, 0, 1),
    (-0.00102296, 3, 3, 0, 1), (-0.0317791, 0, 3, 1, 1), (0.018604, 1, 0, 2, 1),
    (-0.00410798, 0, 2, 2, 1), (-0.000606848, 0, 0, 0, 2), (-0.0049819, 1, 0, 0, 2),
    (0.0025983, 2, 0, 0, 2), (-0.000560528, 3, 0, 0, 2), (-0.00163652, 1, 2, 0, 2),
    (-0.000328787, 1, 6, 0, 2), (0.000116502, 2, 6, 0, 2), (0.000690904, 0, 0, 1, 2),
    (0.00421749, 0, 3, 1, 2), (5.65229e-05, 3, 6, 1, 2), (-0.00146564, 0, 3, 2, 2),
)  # fmt: skip
"""Coefficient of KT, powers of J, P/D, AE/A0 and Z."""
TORQUE: Final = (
    (0.00379368, 0, 0, 0, 0), (0.00886523, 2, 0, 0, 0), (-0.032241, 1, 1, 0, 0),
    (0.00344778, 0, 2, 0, 0), (-0.0408811, 0, 1, 1, 0), (-0.108009, 1, 1, 1, 0),
    (-0.0885381, 2, 1, 1, 0), (0.188561, 0, 2, 1, 0), (-0.00370871, 1, 0, 0, 1),
    (0.00513696, 0, 1, 0, 1), (0.0209449, 1, 1, 0, 1), (0.00474319, 2, 1, 0, 1),
    (-0.00723408, 2, 0, 1, 1), (0.00438388, 1, 1, 1, 1), (-0.0269403, 0, 2, 1, 1),
    (0.0558082, 3, 0, 1, 0), (0.0161886, 0, 3, 1, 0), (0.00318086, 1, 3, 1, 0),
    (0.015896, 0, 0, 2, 0), (0.0471729, 1, 0, 2, 0), (0.0196283, 3, 0, 2, 0),
    (-0.0502782, 0, 1, 2, 0), (-0.030055, 3, 1, 2, 0), (0.0417122, 2, 2, 2, 0),
    (-0.0397722, 0, 3, 2, 0), (-0.00350024, 0, 6, 2, 0), (-0.0106854, 3, 0, 0, 1),
    (0.00110903, 3, 3, 0, 1), (-0.000313912, 0, 6, 0, 1), (0.0035985, 3, 0, 1, 1),
    (-0.00142121, 0, 6, 1, 1), (-0.00383637, 1, 0, 2, 1), (0.0126803, 0, 2, 2, 1),
    (-0.00318278, 2, 3, 2, 1), (0.00334268, 0, 6, 2, 1), (-0.00183491, 1, 1, 0, 2),
    (0.000112451, 3, 2, 0, 2), (-2.97228e-05, 3, 6, 0, 2), (0.000269551, 1, 0, 1, 2),
    (0.00083265, 2, 0, 1, 2), (0.00155334, 0, 2, 1, 2), (0.000302683, 0, 6, 1, 2),
    (-0.0001843, 0, 0, 2, 2), (-0.000425399, 0, 3, 2, 2), (8.69243e-05, 3, 3, 2, 2),
    (-0.0004659, 0, 6, 2, 2), (5.54194e-05, 1, 6, 2, 2),
)  # fmt: skip
"""Coefficient of KQ, powers of J, P/D, AE/A0 and Z."""
RANGES: Final = {"P/D": (0.5, 1.4), "AE/A0": (0.3, 1.05), "blades": (2, 7)}
"""Of the propellers behind the polynomials."""


def open_water_curve(
    J: Array, *, pitch: float, area_ratio: float, blades: int
) -> tuple[Array, Array]:
    """KT and KQ over the advance ratio.

    Examples
    --------
    A B4-55 with P/D = 1 at rest:

    >>> KT, KQ = open_water_curve(np.array([0.0, 0.6]), pitch=1.0, area_ratio=0.55, blades=4)
    >>> KT.round(3), KQ.round(4)
    (array([0.424, 0.224]), array([0.0613, 0.0366]))
    """
    stated = {"P/D": pitch, "AE/A0": area_ratio, "blades": blades}
    outside = [
        f"{name} = {stated[name]:g} lies outside {low:g} to {high:g}"
        for name, (low, high) in RANGES.items()
        if not low <= stated[name] <= high
    ]
    if outside:
        raise DataError(f"No propeller of the Wageningen B series: {'; '.join(outside)}.")
    KT, KQ = (
        np.sum(
            [c * J**s * pitch**t * area_ratio**u * float(blades) ** v for c, s, t, u, v in table],
            axis=0,
        )
        for table in (THRUST, TORQUE)
    )
    return KT, KQ
