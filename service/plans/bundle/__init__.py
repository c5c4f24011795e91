"""bundle.zip: a finished plan with all that it was made from, and its replay elsewhere."""
