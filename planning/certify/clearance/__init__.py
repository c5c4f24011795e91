"""That bodies keep their distances between samples too."""
