"""Tools that are no tests: planted errors, what a change reaches, other processors, ratios."""
