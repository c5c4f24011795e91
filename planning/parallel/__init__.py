"""Processes side by side: forked attempts, shared cores, files that are written whole."""
