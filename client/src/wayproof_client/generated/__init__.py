"""What `python -m client.generator` makes of the OpenAPI document."""
