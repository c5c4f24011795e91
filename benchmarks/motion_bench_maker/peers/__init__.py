"""Other planners on the same problems: in this run, each in its own interpreter, or earlier."""
