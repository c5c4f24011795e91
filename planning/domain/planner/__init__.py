"""Planners, their graphs, roadmaps and regions."""
