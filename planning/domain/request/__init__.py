"""Planning request besides its goal: options, path constraints, motion limits, deadlines."""
