"""What decides a plan besides its goal: options, constraints, limits, deadlines."""
