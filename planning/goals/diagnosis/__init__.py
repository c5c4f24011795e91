"""Diagnosis of goal failures: nearest feasible goal and sufficient relaxations; after a failure."""
