"""A loaded scene in the native kernel."""
