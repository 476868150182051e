"""The workbench: a page in a browser where a model meets its tests, and the server behind it."""

from pmmkit.workbench.serving import serve

__all__ = ["serve"]
