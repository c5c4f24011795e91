"""Path constraints compiled for the search; the certifier has code of its own."""
