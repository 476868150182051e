"""Whether a filter is right about itself: size and whiteness of what it did not expect."""

from __future__ import annotations

from pmmkit.identification.filters import Filtered
from pmmkit.inference import LAGS, Consistency, innovation_tests


def consistency(found: Filtered, *, lags: int = LAGS) -> Consistency:
    """Test whether the innovations of a filter are as large as it thinks, and white.

    Parameters
    ----------
    found : Filtered
        Result of a Kalman filter.
    lags : int
        Samples over which correlations are looked for.

    Returns
    -------
    Consistency

    Raises
    ------
    DataError
        If `lags` is not positive.

    Notes
    -----
    The filters take the channels of an instant one after another, so the innovations of a right
    filter are independent across channels too, and n times the mean of the normalised squares is
    chi square distributed with n degrees of freedom (Bar-Shalom, Li and Kirubarajan 2001, section
    5.4). Pairs with a gap between them, or across records, are left out of the correlations.
    """
    return innovation_tests(found.innovations, lags=lags)
