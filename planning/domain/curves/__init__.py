"""Paths, curves and samples of motions."""
