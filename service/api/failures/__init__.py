"""Failures and problems by code: what the evidence of each has."""
