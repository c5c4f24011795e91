"""Who may ask the service for what, how often, and what is written down of it."""
