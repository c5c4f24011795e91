"""Path constraints as the search asks about them; the certifier has code of its own."""
