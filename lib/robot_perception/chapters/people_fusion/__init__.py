"""People, by committee: the whole system of Schaffernicht et al., from signals to behaviour."""
