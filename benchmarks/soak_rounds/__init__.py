"""Rounds of the soak of executions, what is done in them, and what is looked at afterwards."""
