"""Motion planning that proves what it plans."""
