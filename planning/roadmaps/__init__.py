"""Probabilistic roadmaps (PRM) of worlds: their cache key, construction and reuse by plans."""
