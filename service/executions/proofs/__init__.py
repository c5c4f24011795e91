"""Proofs of motions in the scene as it is: before they begin, and while they are carried out."""
