"""Plans as resources: admission, and jobs to the wire."""
