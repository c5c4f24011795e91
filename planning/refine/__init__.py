"""Refinement: optimization of a free path into a smooth, quick, free curve, or no change of it."""
