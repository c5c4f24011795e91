"""Execute: follow a timed trajectory with a driver, decide what happens, say how it goes."""
