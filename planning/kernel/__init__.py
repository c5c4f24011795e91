"""Native kernel: fast conservative collision checks and batched kinematics, and shape coverings."""
