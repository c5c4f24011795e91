"""Inverse kinematics (IK): configurations that bring a tool frame to target poses."""
