"""Frozen values that cross every boundary: numpy and str, no engine."""
