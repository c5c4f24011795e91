"""Bounds on whole intervals: polynomials, Taylor series, branch and bound."""
