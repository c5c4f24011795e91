"""Results of a plan: motion, certificate and the reports of its stages."""
