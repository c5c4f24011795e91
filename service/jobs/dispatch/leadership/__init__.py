"""Which server of a database runs its jobs."""
