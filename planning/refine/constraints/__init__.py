"""What bounds a curve: distances, rates, loads, path constraints."""
