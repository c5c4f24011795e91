"""Which poses a tool frame may take: one, a ball or a region of them."""
