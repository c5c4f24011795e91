"""What a plan gives: motion, certificate and the reports of its stages."""
