"""Joints, groups of joints and what they may do."""
