"""Questions in JSON: what is asked, and what is answered."""
