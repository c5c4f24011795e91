"""The client of `wayproof_client` by the names that it had in this package."""
