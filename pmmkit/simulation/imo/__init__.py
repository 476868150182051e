"""Criteria of IMO resolution MSC.137(76): what each asks, whether a ship meets it, and where."""
