"""Joint checks: positions, rates and locks of joints at every instant of a trajectory."""
