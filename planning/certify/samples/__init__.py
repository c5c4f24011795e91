"""Whether the samples of a motion stand for it, as a receiver may read them."""
