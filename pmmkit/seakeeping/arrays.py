"""Kinds of arrays of this room beside `pmmkit.numerics.Array`."""

import numpy as np
from numpy.typing import NDArray

Complex = NDArray[np.complex128]
Flags = NDArray[np.bool_]
