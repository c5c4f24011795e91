"""What the resources share: they import this, and it knows none of them."""
