"""Retiming: from a geometric path to a timed trajectory exactly on it, by TOPP-RA or ruckig."""
