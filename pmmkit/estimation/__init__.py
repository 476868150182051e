"""Estimation that knows nothing of ships: tests of innovations, convergence of draws."""
