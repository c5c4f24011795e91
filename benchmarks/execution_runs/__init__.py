"""Sections of the benchmark of executions, a file each."""
