"""Search: from goal configurations to a collision-free path, by OMPL; the only user of OMPL."""
