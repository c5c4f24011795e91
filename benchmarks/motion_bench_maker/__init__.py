"""The parts of `benchmarks/mbm.py`: problems, robots, runs, the referee and the tables."""
