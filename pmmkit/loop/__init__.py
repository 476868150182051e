"""The loop: compare, diagnose, add, watch the error fall, undo, replay."""

from pmmkit.loop.session import ErrorFall, Session, begin, fit, replay

__all__ = ["ErrorFall", "Session", "begin", "fit", "replay"]
