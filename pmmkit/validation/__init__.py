"""Models beside tests: errors against what may differ anyway, and where they stand out."""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.validation.captive import CaptiveRun, observed
    from pmmkit.validation.comparison import Comparison
    from pmmkit.validation.dataset import errors_in_percent, measures_in_percent
    from pmmkit.validation.free_running import FreeRun, ManoeuvreComparison, as_tested
    from pmmkit.validation.joint import JointComparison, compare
    from pmmkit.validation.submission import compare_submission

__all__ = [
    "CaptiveRun",
    "Comparison",
    "FreeRun",
    "JointComparison",
    "ManoeuvreComparison",
    "as_tested",
    "compare",
    "compare_submission",
    "errors_in_percent",
    "measures_in_percent",
    "observed",
]

lazy(__name__)
