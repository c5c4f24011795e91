"""Steering for cars: Dubins and Reeds-Shepp curves as edges of a search."""
