"""Webhooks: what happens to jobs is told to registered addresses, signed, until they take it."""
