"""Functions as MATLAB."""
