"""Transfer functions as VERES writes them: for speeds, headings and frequencies, six modes each."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np


@dataclass(frozen=True)
class Transfer:
    speed: np.ndarray
    heading_deg: np.ndarray
    omega: np.ndarray
    values: np.ndarray


def read_transfer(path: Path) -> Transfer:
    """Files .re1 (motions) and .re8 (forces); VERES's 0° is head sea, here that is 180°."""
    rows = [line.split() for line in path.read_text(encoding="latin-1").splitlines()]
    start = next(k for k, row in enumerate(rows) if len(row) == 4 and row[3] == "6")
    speeds, headings, frequencies, modes = (int(cell) for cell in rows[start])
    lines = iter(rows[start + 1 :])
    U, heading, omega = np.zeros(speeds), np.zeros(headings), np.zeros(frequencies)
    values = np.zeros((modes, speeds, headings, frequencies), dtype=complex)
    for a in range(speeds):
        U[a] = float(next(lines)[0])
        for b in range(headings):
            heading[b] = float(next(lines)[0])
            for c in range(frequencies):
                omega[c] = float(next(lines)[0])
                for mode in range(modes):
                    values[mode, a, b, c] = complex(*map(float, next(lines)[1:]))
    return Transfer(U, 180.0 - heading, omega, values)
