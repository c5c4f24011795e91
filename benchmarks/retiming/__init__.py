"""Retiming compared: the same random paths, timed by us and by others, judged alike."""
