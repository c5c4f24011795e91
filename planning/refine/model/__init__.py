"""Convex model of a curve's neighbourhood: variables, rows, and the quadratic program."""
