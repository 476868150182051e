"""Sea trials: measures of turning circles, zigzags and stops from positions and heading."""
