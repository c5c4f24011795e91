"""Inverse kinematics: from poses of a tool frame to configurations."""
