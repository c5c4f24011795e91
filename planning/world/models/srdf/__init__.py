"""SRDF (MoveIt): what the file beside a URDF says, and what of it is not read."""
