"""Whether a motion can be stopped anywhere on its way, and how soon."""
