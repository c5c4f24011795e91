"""What limits a motion along a path besides the limits of its joints."""
