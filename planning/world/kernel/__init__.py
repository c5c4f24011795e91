"""Loaded scenes in the native kernel: links, joints, collision pairs and collision checks."""
