"""Robot descriptions: URDF, SDF, MJCF and SRDF, with groups and limits."""
