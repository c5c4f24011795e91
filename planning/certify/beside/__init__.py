"""Proofs that motions of several groups keep their margins whatever their timing."""
