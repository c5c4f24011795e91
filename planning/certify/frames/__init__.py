"""Frame checks: position, speed, acceleration and rotation of frames on whole intervals."""
