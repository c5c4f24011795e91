"""From a scene to Drake: robots, objects, frames and what may touch."""
