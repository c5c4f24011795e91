"""OMPL: spaces, planners and callbacks. Nothing else imports it."""
