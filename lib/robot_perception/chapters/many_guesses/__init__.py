"""Many guesses: particles in the corridor with three doors, their weights, how they are drawn."""
