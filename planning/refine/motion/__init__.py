"""Motions in time as splines: their objectives, and how these are optimized by any solver."""
