"""That joints keep their limits between samples too."""
