"""From a model to the right-hand side of its equations of motion."""
