"""Makes what `wayproof_client` has of the OpenAPI document: models, requests and operations."""
