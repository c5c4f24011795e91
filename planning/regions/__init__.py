"""Regions: collision-free convex sets (IRIS-ZO), and shortest paths through them (GCS)."""
