"""Stopping: stops along the path from any instant of a motion, and their duration."""
