"""Plans: requests for motions, the jobs that make them, and what is delivered of them."""
