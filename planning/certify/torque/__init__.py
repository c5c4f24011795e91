"""Joint torques on whole intervals, against the limits on effort."""
