"""Sample proofs: motions that receivers interpolate from the samples of a proven motion."""
