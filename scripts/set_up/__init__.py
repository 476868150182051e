"""Setting up the environment."""
