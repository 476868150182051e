"""The golden set: what the package answers today, and what a change has moved."""
