"""Executions as resources: admission, where the robots are, and jobs to the wire."""
