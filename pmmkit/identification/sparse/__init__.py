"""Sparse regression: which terms of a library records ask for."""
