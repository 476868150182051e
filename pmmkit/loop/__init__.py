"""The loop: compare, diagnose, add, watch the error fall, undo, replay."""

from pmmkit.loop.error_fall import ErrorFall
from pmmkit.loop.joint_fall import JointFall
from pmmkit.loop.record_fall import RecordError, RecordFall
from pmmkit.loop.session import Session, begin, fit, replay

__all__ = [
    "ErrorFall",
    "JointFall",
    "RecordError",
    "RecordFall",
    "Session",
    "begin",
    "fit",
    "replay",
]
