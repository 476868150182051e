"""The loop: compare, diagnose, add, watch the error fall, undo, replay."""
