"""TOPP-RA retiming: time-optimal profiles under velocity and acceleration limits."""
