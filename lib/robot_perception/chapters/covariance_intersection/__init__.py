"""Two opinions, one belief: Schaffernicht et al., section 3.2, eqs 1–6."""
