"""Poses, rotations, shapes and pairs of bodies."""
