"""What free-running records say that a model lacks."""
