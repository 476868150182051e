"""Estimation that knows nothing of ships: sparse least squares."""
