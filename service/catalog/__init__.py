"""What there is to choose from: robots and planners."""
