"""Clearance proofs: pairs of bodies keep their margins at every instant of a trajectory."""
