"""Colour and shape: Andrade-Cetto, section 3.3, Figs 8 and 10–13."""
