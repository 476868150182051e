"""Models beside tests: errors against what may differ anyway, and where they stand out."""
