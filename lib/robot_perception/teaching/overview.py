"""The papers at a glance: which chapters rebuild each, and what came of its claims."""

from collections.abc import Mapping
from html import escape

from robot_perception.teaching.badges import EXPLAINED, SHEETS, recorded, style
from robot_perception.teaching.ledger import Ledger, verdicts
from robot_perception.teaching.media import Shown, html_table
from robot_perception.teaching.outputs import output
from robot_perception.teaching.papers import PAPERS

HEAD = ("Paper", "Rebuilt in", "Verdicts")
TO_COME = "a later chapter"
HOLDS = {
    "perception-issues": "Splitting finds {dp-recursive:.0%} of a scan's straight parts, and "
    "colour with shape follows {four-experiments:.0%} of the rendered objects to the end "
    "of their films. "
    "On a rail the first error stays for ever, as printed, and an anchor removes it. On a floor "
    "one anchor leaves the map free to turn, and the rule of 50 revisions multiplies the NEES by "
    "{controllability-rule:.0f}.",
    "sift-slam": "Fifty particles map a building as well as four hundred ({map-50:.2f} times the "
    "error), and a robot finds its place in the finished map from {map-localises:.0%} of the "
    "starts. The Mahalanobis distance assigns more descriptors, as in the paper's table, though "
    "most of that is the averaging. It makes the map no better ({mahalanobis-map:.2f} times the "
    "error), and of maps made with ten particles {map-10:.0%} have the right topology.",
    "sensor-aggregation": "Covariance intersection is consistent at every correlation, and sonars "
    "place {sonar-distance:.1f} times as many people behind the robot. {rate-93:.0%} of the people "
    "are tracked where the paper has 93 %. Visitors who leave a survey are asked back in "
    "{survey-breaks-off:.0%} of the stories; those who leave a guide in {guide-asks-back:.0%}.",
    "ceiling-navigation": "Grey vectors tolerate other light ({normalised-light:.2f} times the "
    "error) and partial cover, and a corrected picture shows the ceiling as a plane. Contours find "
    "{pattern-model:.0%} of the patterns again. The mosaic as printed drifts by {mosaic-fig9:.0%} "
    "of the distance, and {visual-memory:.0%} of the drives repeat the path that was shown.",
    "companion-robot": "Open hands ({hand-detector:.0%}), arms that point ({pointing:.0%}) and a "
    "person behind another one ({patch-occlusion:.0%}) are found as described. Each part of an "
    "interaction works; all its orders together lead to their states in {interaction-states:.0%} "
    "of the visits. Whether a Kalman filter bridges missed faces better than the last detection "
    "stays open.",
    "ours": "What the papers did not state and their systems answer: how sure a filter may be, "
    "what happens where one paper's part meets another's, and which of their numbers matter.",
}
"""What holds of each paper, by its key, with the values of claims."""


def overview(titles: Mapping[str, str]) -> Shown:
    """Return the papers as a table: the chapters that rebuild each, and how many verdicts of which.

    Parameters
    ----------
    titles
        Titles of the chapters by stem, in the order of the book.
    """
    rows, lines = [], []
    for key, paper in PAPERS.items():
        claims = Ledger(tuple(e for e in recorded().entries if e.paper == key))
        stems = [stem for stem in titles if any(e.chapter == stem for e in claims.entries)]
        links = ", ".join(f'<a href="{s}.html">{escape(titles[s])}</a>' for s in stems)
        counts = verdicts(claims)
        badges = " ".join(
            f'<a class="{style(verdict)}" href="scorecard.html#claims-of-{key}" '
            f'title="{EXPLAINED[verdict]}">'
            f'<span class="rp-badge-verdict">{count}</span> {verdict}</a>'
            for verdict, count in counts.items()
        )
        rows.append(
            f'<tr><th scope="row">{escape(paper.title)} <small>{escape(paper.citation)}</small>'
            f'</th><td class="rp-text">{links or TO_COME}</td>'
            f'<td class="rp-text"><p class="rp-badges">{badges or "–"}</p></td></tr>'
        )
        told = ", ".join(f"{count} {verdict}" for verdict, count in counts.items())
        lines.append(f"{paper.citation}: {told or TO_COME}")
    head = "".join(f'<th scope="col">{name}</th>' for name in HEAD)
    html = html_table("Papers and verdicts", "rp-papers", head, "".join(rows))
    return output(html, "\n".join(lines), *SHEETS)


def explained() -> Shown:
    """Return the verdicts with what each of them means, as a list for who meets them first."""
    html = "".join(
        f'<dt><span class="{style(verdict)}"><span class="rp-badge-verdict">{verdict}</span></span>'
        f"</dt><dd>{escape(means)}</dd>"
        for verdict, means in EXPLAINED.items()
    )
    text = "\n".join(f"{verdict}: {means}" for verdict, means in EXPLAINED.items())
    return output(f'<dl class="rp-verdicts">{html}</dl>', text, *SHEETS)
