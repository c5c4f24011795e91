"""What is drawn in the 3-D view of one browser."""
