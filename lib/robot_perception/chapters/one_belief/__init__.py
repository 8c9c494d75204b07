"""One belief: a corridor with three doors, from a list of numbers to the extended Kalman filter."""
