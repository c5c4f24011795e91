"""Drake's kinematic trajectory optimization as a method of refinement."""
