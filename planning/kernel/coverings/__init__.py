"""Coverings: convex shapes between spheres around them and spheres inside them."""
