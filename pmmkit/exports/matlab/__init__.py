"""Models and tables as functions for MATLAB and Octave."""
