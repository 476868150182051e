"""The catalogue of effects: what acts on a ship, one family a file."""
