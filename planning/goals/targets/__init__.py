"""Target poses of a tool frame: a single pose, a ball or a region of poses, and their sampling."""
