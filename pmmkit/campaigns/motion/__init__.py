"""How the model moved."""
