"""Roadmaps of worlds: what identifies one, and where it is kept between plans."""
