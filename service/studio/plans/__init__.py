"""Plans: asked for, followed, failed."""
