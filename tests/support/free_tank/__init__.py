"""A tank of free-running ships of its own: two ships, hidden effects, sensors, campaigns.

It shares no code with the package and imports nothing of it: equations, integration, steering and
noise are written here again, and what is hidden enters at its physical source.
"""
