"""Search: a collision-free path from the start to a goal configuration; the only user of OMPL."""
