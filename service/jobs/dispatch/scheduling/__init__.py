"""What waits, which of it goes next, and the workers that it gets."""
