"""Regions: convex sets of free configurations, grown beforehand, and shortest paths inside them."""
