"""Scenes as values: robots, objects, frames, margins, edit operations and files."""
