"""Live states of scenes: shown, and streamed as they change."""
