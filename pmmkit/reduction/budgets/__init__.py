"""Budgets of uncertainty by source: of derivatives, of manoeuvres, and of computed grids."""
