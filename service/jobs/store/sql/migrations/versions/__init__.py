"""One revision a file, numbered; a revision that was released never changes."""
