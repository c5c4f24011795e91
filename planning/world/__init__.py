"""World: scenes loaded into Drake; the sole owner of Drake state."""
