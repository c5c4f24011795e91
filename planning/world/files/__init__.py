"""Files of a scene: search, storage by content, and validation before Drake parses them."""
