"""Scene documents: parsing, validation, editing and writing."""
