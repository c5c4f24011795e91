"""Plans in JSON: what is asked for, and what is answered."""
