"""Joints, joint groups, limits, steering and configuration manifolds."""
