"""Endpoints: they translate and delegate, and declare every answer they give."""
