"""Strip theory beside tank tests: Journée's Wigley hulls in head waves at rest (1992).

What else was measured on them stands in scripts/validation/wigley.py, and
tests/house/test_published.py holds each figure to its share.
"""

from __future__ import annotations

import numpy as np
import pytest

from scripts.validation.tank import places, sailed
from scripts.validation.wigley import AT_REST, L


@pytest.mark.slow
@pytest.mark.parametrize("model", AT_REST)
def test_heave_and_pitch_at_rest(model):
    """Heave to .04 of the wave (rms), pitch to .1 of 2πζ/L: low, as its own strip codes found, and
    lower by .02 since the pressure on the ends has its moment, without which the limit of long
    waves is not the slope."""
    lengths, heave, pitch, lead = np.array(AT_REST[model]).T
    ours = sailed(model).motion[:, 0, 0, places(tuple(lengths))]
    assert np.sqrt(np.mean((np.abs(ours[2]) - heave) ** 2)) < 0.045
    assert np.sqrt(np.mean((np.abs(ours[4]) * L / (2 * np.pi) - pitch) ** 2)) < 0.1
    off = np.degrees(np.angle(ours[2] / ours[4] * np.exp(-1j * np.radians(lead))))
    assert np.abs(off[lengths >= 1.0]).max() < 20.0
