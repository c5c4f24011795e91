"""What operators see of a server and its workers: lines of the log, and traces."""
