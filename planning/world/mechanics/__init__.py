"""Kinematics, dynamics and simulation of a loaded scene."""
