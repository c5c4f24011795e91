"""What a user of the library calls besides `plan`, one call in each file."""
