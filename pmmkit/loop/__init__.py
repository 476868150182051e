"""The loop: compare, diagnose, add, watch the error fall, undo, replay."""

from pmmkit.loop.error_fall import ErrorFall
from pmmkit.loop.evidence import Evidence, Fall
from pmmkit.loop.record_fall import RecordError, RecordFall
from pmmkit.loop.session import Session, begin, fit, replay

__all__ = [
    "ErrorFall",
    "Evidence",
    "Fall",
    "RecordError",
    "RecordFall",
    "Session",
    "begin",
    "fit",
    "replay",
]
