"""Axes from arrays: nothing of runs, models or tables."""
