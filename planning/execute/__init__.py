"""Execution of timed trajectories on a robot or a simulation: state machine, driver and status."""
