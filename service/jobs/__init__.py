"""Durable jobs in supervised, killable worker processes; knows nothing of planning."""
