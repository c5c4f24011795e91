"""Public functions of the library besides `plan`, one call per file."""
