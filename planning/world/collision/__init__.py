"""Distances and collisions of a loaded scene, and the margins that are demanded."""
