"""The samples of a run: read, converted to SI and our axes, corrected."""
