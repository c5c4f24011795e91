"""Where the robot shall go."""
