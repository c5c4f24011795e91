"""Straight moves of a tool: lines that are traced, approaches and retreats."""
