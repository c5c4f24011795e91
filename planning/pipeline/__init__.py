"""Pipeline of the planning stages: read `plan.py` first. Only this package joins several stages."""
