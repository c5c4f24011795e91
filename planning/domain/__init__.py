"""Domain values: frozen dataclasses of arrays and text that cross every boundary, engine-free."""
