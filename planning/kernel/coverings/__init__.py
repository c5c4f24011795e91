"""Coverings: outer spheres that contain a convex shape, and inner spheres inside it."""
