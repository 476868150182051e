"""MATLAB files (.mat)."""
