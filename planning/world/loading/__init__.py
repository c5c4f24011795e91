"""Loading a scene into Drake: robots, objects, frames and collision filters."""
