"""Jerk-limited retiming: profiles and transitions by ruckig and an interior-point optimizer."""
