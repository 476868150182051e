"""Functions of the equations as C."""
