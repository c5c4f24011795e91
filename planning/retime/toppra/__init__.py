"""Time-optimal profiles under velocity and acceleration limits, by TOPP-RA."""
