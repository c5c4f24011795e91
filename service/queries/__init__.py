"""Questions to a scene that are answered at once: check, fk, ik, line."""
