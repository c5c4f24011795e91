"""What there is: scenes, their operations and files."""
