"""From a geometric path to a timed trajectory that is exactly on it."""
