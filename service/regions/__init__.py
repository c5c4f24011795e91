"""Regions as resources: admission, which of them a plan uses, and jobs to the wire."""
