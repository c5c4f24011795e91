"""Refinement for cars: quicker arcs and lines that the car can drive as they are."""
