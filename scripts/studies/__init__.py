"""Longer studies, whose figures the documentation quotes."""
