"""Pictures of scenes, drawn in numpy: no graphics card, no browser, the same bytes each time."""
