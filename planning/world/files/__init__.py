"""Files that a scene is made of: found, kept by content, and looked at before Drake reads them."""
