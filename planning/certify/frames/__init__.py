"""Where frames are, how fast they move and turn, on whole intervals."""
