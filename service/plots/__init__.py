"""Plots of delivered motions, as SVG."""
