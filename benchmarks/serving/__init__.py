"""A server as a user runs it, for benchmarks of the service: started, ended, looked into."""
