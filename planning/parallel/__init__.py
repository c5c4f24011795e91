"""Parallel execution: a pool of forked processes, CPU core leases and atomic file writes."""
