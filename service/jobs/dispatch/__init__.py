"""How jobs run: queues, workers to run them in, and the attempts that end in the table."""
