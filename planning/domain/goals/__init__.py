"""What a motion shall reach, and what was found of it."""
