"""Formulas and functions as trees, read from Python's text, and what each language calls them."""
