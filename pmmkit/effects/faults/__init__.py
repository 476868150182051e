"""Faults of a measurement: one size for all runs and channels is what betrays them.

They act on what is recorded, never on the ship: no model has one as a part. A fault says what a
unit of it does to the harmonics of a run; derivatives along the motion are taken by small steps
from the base that was fitted.
"""
