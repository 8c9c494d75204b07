"""The papers that the book rebuilds: their keys in claims, and how a reader cites them."""

from dataclasses import dataclass

from robot_perception.checks import one_of


@dataclass(frozen=True, slots=True)
class Paper:
    """A paper as the book names it: author and year, title, and key in the bibliography."""

    citation: str
    title: str
    reference: str


PAPERS = {
    "perception-issues": Paper(
        "Andrade-Cetto 2004", "Perception Issues in Mobile Robotics", "andrade2004perception"
    ),
    "sift-slam": Paper(
        "Gil et al. 2006",
        "Simultaneous Localization and Mapping in Indoor Environments Using SIFT Features",
        "gil2006",
    ),
    "sensor-aggregation": Paper(
        "Schaffernicht et al. 2005",
        "A Probabilistic Multimodal Sensor Aggregation Scheme Applied for a Mobile Robot",
        "schaffernicht2005",
    ),
    "ceiling-navigation": Paper(
        "Ait Aider et al. 2004",
        "Indoor Autonomous Navigation Using Visual Memory and Pattern Tracking",
        "aitaider2004",
    ),
    "companion-robot": Paper(
        "Menezes et al. 2006", "Visual Tracking Modalities for a Companion Robot", "menezes2006"
    ),
}
"""Papers by the key that a claim names."""


def paper(key: str) -> Paper:
    """Return a paper by its key.

    Raises
    ------
    ValueError
        If no paper has that key.
    """
    return PAPERS[one_of("key", key, PAPERS)]
