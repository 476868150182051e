"""Manoeuvres: one file a family, each entry declared once; `catalogue` finds them."""
