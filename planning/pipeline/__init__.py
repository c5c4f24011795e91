"""The stages joined: read `plan.py` first. The only place that knows more than one stage."""
