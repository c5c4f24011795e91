"""Local optimizations of curves: trust regions, audited descents, and the best of several."""
