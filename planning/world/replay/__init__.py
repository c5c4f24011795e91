"""Motions as pages of HTML that need no server."""
