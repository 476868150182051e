"""The loop: compare, diagnose, add, watch the error fall, undo, replay."""

from pmmkit.loop.fall import Fall, FallRow, Told
from pmmkit.loop.session import Session, begin, fit, replay

__all__ = ["Fall", "FallRow", "Session", "Told", "begin", "fit", "replay"]
