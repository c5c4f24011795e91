"""Worker processes: one task at a time, each can be killed; no SQL and no web here."""
