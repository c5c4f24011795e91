"""Failures that are made to happen on private servers: for pictures and examples of the guide."""
