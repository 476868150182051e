"""Evidence of several campaigns of one ship at once, captive and free running."""
