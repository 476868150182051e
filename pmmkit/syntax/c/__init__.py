"""Functions as C."""
