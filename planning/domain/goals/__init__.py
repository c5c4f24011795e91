"""Goals of a motion, and the results of inverse kinematics and straight-line tracing for them."""
