"""Sine, cosine, exponential and arctangent without branches and calls, for loops over lanes.

A compiler makes vectors of such a loop where the functions of the C library would be called lane
by lane. Arguments are reduced as usual (Cody and Waite 1980), the series are those of Taylor, the
arctangent's is through the Chebyshev places of its interval: all are within 2 units in the last
place, of angles below 10⁵ rad.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from math import fabs, pi
from typing import Any, Final

from pmmkit.effects import rebound

_SHIFT: Final = 6755399441055744.0
"""1.5 · 2⁵²: a number added to it is rounded to a whole one, which its last bits hold."""
_PARTS_OF_PI: Final = (1.5707963267341256, 6.077100506303966e-11, 2.0222662487959506e-21)
"""π/2 in parts of 33 bits, so that whole multiples of the first two are exact."""
_PARTS_OF_LOG_2: Final = (0.6931471803691238, 1.9082149292705877e-10)


def bits(x: float) -> int:
    """The 64 bits of a float as a whole number."""
    return int.from_bytes(struct.pack("<d", x), "little", signed=True)


def of_bits(i: int) -> float:
    """The float that 64 bits stand for."""
    return float(struct.unpack("<d", (i % 2**64).to_bytes(8, "little"))[0])


def bits_of_both(a: int, b: int) -> int:
    """Bits that two numbers have."""
    return a & b


def bits_of_one(a: int, b: int) -> int:
    """Bits that one of two numbers has."""
    return a ^ b


def bits_moved(a: int, places: int) -> int:
    """Bits so many places higher; `of_bits` leaves out those that are moved out."""
    return a << places


def _of_quarter(x: float, further: int) -> float:
    """Sine of an angle and of so many right angles more."""
    shifted = x * (2.0 / pi) + _SHIFT
    right_angles = shifted - _SHIFT
    a = x - right_angles * _PARTS_OF_PI[0]
    a = (a - right_angles * _PARTS_OF_PI[1]) - right_angles * _PARTS_OF_PI[2]
    z = a * a
    sine = a * (
        1.0
        + z
        * (
            -1.0 / 6.0
            + z
            * (
                1.0 / 120.0
                + z
                * (
                    -1.0 / 5040.0
                    + z
                    * (
                        1.0 / 362880.0
                        + z
                        * (
                            -1.0 / 39916800.0
                            + z
                            * (
                                1.0 / 6227020800.0
                                + z * (-1.0 / 1307674368000.0 + z * (1.0 / 355687428096000.0))
                            )
                        )
                    )
                )
            )
        )
    )
    cosine = 1.0 + z * (
        -1.0 / 2.0
        + z
        * (
            1.0 / 24.0
            + z
            * (
                -1.0 / 720.0
                + z
                * (
                    1.0 / 40320.0
                    + z
                    * (
                        -1.0 / 3628800.0
                        + z
                        * (
                            1.0 / 479001600.0
                            + z
                            * (
                                -1.0 / 87178291200.0
                                + z * (1.0 / 20922789888000.0 + z * (-1.0 / 6402373705728000.0))
                            )
                        )
                    )
                )
            )
        )
    )
    quarter = bits(shifted) + further
    value = cosine if bits_of_both(quarter, 1) != 0 else sine
    return of_bits(bits_of_one(bits(value), bits_moved(bits_of_both(quarter, 2), 62)))


def sin(x: float) -> float:
    """Sine."""
    return _of_quarter(x, 0)


def cos(x: float) -> float:
    """Cosine."""
    return _of_quarter(x, 1)


def exp(x: float) -> float:
    """Exponential function, held beyond ±700."""
    x = x if x > -700.0 else -700.0
    x = x if x < 700.0 else 700.0
    shifted = x * (1.0 / 0.6931471805599453) + _SHIFT
    halvings = shifted - _SHIFT
    a = (x - halvings * _PARTS_OF_LOG_2[0]) - halvings * _PARTS_OF_LOG_2[1]
    power = 1.0 + a * (
        1.0 / 1.0
        + a
        * (
            1.0 / 2.0
            + a
            * (
                1.0 / 6.0
                + a
                * (
                    1.0 / 24.0
                    + a
                    * (
                        1.0 / 120.0
                        + a
                        * (
                            1.0 / 720.0
                            + a
                            * (
                                1.0 / 5040.0
                                + a
                                * (
                                    1.0 / 40320.0
                                    + a
                                    * (
                                        1.0 / 362880.0
                                        + a
                                        * (
                                            1.0 / 3628800.0
                                            + a
                                            * (
                                                1.0 / 39916800.0
                                                + a * (1.0 / 479001600.0 + a * (1.0 / 6227020800.0))
                                            )
                                        )
                                    )
                                )
                            )
                        )
                    )
                )
            )
        )
    )
    return power * of_bits(bits_moved(bits(shifted) + 1023, 52))


def tanh(x: float) -> float:
    """Hyperbolic tangent."""
    falling = exp(-2.0 * fabs(x))
    value = (1.0 - falling) / (1.0 + falling)
    return value if x >= 0.0 else -value


def atan2(y: float, x: float) -> float:
    """Angle of a point; 0 at the origin."""
    across, along = fabs(y), fabs(x)
    low = across if across < along else along
    high = along if across < along else across
    far = low > 0.41421356237309503 * high
    above = low - high if far else low
    below = low + high if far else high
    t = above / (below if below > 0.0 else 1.0)
    z = t * t
    value = t * (
        1.0
        + z
        * (
            -0.3333333333333312
            + z
            * (
                0.19999999999940363
                + z
                * (
                    -0.14285714279201633
                    + z
                    * (
                        0.11111110742705407
                        + z
                        * (
                            -0.09090896750160893
                            + z
                            * (
                                0.07692044346527491
                                + z
                                * (
                                    -0.06662941171835111
                                    + z
                                    * (
                                        0.05846803988621949
                                        + z
                                        * (
                                            -0.05034779053994625
                                            + z
                                            * (0.03795728422740706 + z * (-0.017796896254340038))
                                        )
                                    )
                                )
                            )
                        )
                    )
                )
            )
        )
    )
    value = value + 0.25 * pi if far else value
    value = 0.5 * pi - value if across > along else value
    value = pi - value if x < 0.0 else value
    return -value if y < 0.0 else value


def use(function: Callable[..., Any]) -> Any:
    """A copy of an effect's function, and of all that it calls, for loops over lanes."""
    own = {"sin": sin, "cos": cos, "exp": exp, "tanh": tanh, "atan2": atan2}
    return rebound(function, own, lambda copy: copy)
