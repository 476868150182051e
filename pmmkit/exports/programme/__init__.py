"""Runs that are to be made, for those who make them: a carriage, or a solver."""
