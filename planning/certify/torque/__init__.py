"""Torque check: joint torques and forces on whole intervals, against effort limits."""
