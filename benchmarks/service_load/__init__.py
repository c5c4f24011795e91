"""How quickly the service answers, what its HTTP costs, and how much it takes."""
