"""Models as Functional Mock-up Units (FMI 3.0 and 2.0), from C source."""
