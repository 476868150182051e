"""The workbench: a page in a browser where a model meets its tests, and the server behind it."""
