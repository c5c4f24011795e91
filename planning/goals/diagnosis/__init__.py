"""Why a goal has no configuration, and what is nearest to it. Runs after a failure only."""
