"""How requests are read and led to their endpoints."""
