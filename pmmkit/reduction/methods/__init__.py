"""The same derivatives by other ways, side by side."""
