"""Derivative tables: what a reduction gives and a model takes."""
