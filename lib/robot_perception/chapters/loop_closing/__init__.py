"""Round the loop: Andrade-Cetto, "Perception Issues", section 2.2, Fig. 7."""

STUDIES = ("building", "posts")
