"""Post-processing of a path: shortcuts, relaxation, repair and resampling."""
