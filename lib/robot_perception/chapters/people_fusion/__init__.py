"""People, by committee: Schaffernicht et al., "A Probabilistic Multimodal Sensor Aggregation"."""

STUDIES = ("modalities", "rates", "trajectories", "behaviours")
