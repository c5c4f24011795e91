"""How scenes are kept: rows, artifacts, and the files of this host."""
