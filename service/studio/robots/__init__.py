"""The robots as they are: carried out, paused, stopped."""
