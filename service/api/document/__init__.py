"""The OpenAPI document: what FastAPI makes of the routes, and what is added to it."""
