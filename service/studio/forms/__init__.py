"""Forms that are made from the server's OpenAPI document."""
