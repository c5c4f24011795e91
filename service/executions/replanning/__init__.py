"""Other motions for executions whose own does not hold."""
