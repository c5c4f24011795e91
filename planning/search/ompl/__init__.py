"""OMPL: state spaces, planners and callbacks. No other package imports the library."""
