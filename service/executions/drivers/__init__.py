"""How the drivers of executions are made and watched."""
