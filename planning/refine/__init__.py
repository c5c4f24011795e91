"""Refine: turn a free path into a smooth, quick, free curve, or leave it alone."""
