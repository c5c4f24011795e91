"""Controls: the names by which a running execution is asked for something."""

IS_PAUSED = "is_paused"
SPEED = "speed"
