"""What captive tests say that a model lacks."""
