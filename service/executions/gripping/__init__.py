"""Grippers: motions of fingers, and what robots hold after them."""
