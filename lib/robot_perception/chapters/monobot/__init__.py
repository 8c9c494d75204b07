"""Chapter "The unobservable monobot": Andrade-Cetto, "Perception Issues", section 2.2."""

STUDIES = ("information",)
