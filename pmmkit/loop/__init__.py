"""The loop: compare, diagnose, add, watch the error fall, undo, replay."""

from pmmkit.loop.fall import ErrorWords, Fall, FallRow
from pmmkit.loop.session import Session, begin, fit, replay

__all__ = ["ErrorWords", "Fall", "FallRow", "Session", "begin", "fit", "replay"]
