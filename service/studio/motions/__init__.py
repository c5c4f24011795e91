"""A planned motion: its time, its curves, its proof."""
