"""pmmkit: from captive ship-model tests to derivatives, a model and manoeuvres."""

__version__ = "0.1.0"
