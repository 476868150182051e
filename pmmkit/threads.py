"""How many threads the linear algebra below takes."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

ONE_THREAD: Final[Mapping[str, str]] = MappingProxyType(
    {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
)
"""Environment in which matrices are factored by one thread, set before numpy is imported.

Ours have a few hundred rows. Two threads of OpenBLAS factor 204 rows of 78 columns in 0.6 ms, one
in 0.2; where another program takes a core, two wait for each other and need 30 to 50 ms: fitting an
effect to eight zigzags then takes 120 s in place of 24 (two cores, 2026).
"""
