"""Native code: fast conservative answers about collision, and kinematics in batches."""
