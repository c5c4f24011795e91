"""Robot descriptions: URDF, SDF, MJCF and SRDF, their groups and limits."""
