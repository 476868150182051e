"""The loop: compare, diagnose, add, watch the error fall, undo, replay."""

from pmmkit.loop.error_fall import ErrorFall
from pmmkit.loop.session import Session, begin, fit, replay

__all__ = ["ErrorFall", "Session", "begin", "fit", "replay"]
