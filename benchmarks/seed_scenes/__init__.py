"""The seeds of this project: scenes with a goal and a time to reach it in."""
