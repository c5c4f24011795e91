"""Plans in JSON: requests, results and reports."""
