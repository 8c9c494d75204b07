"""Ways through the book: the graph of its chapters, and paths for readers with one aim."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

from matplotlib.patches import Arc

from explorables.figures import MEANING, figure, to_svg
from explorables.media import Shown, html_table
from explorables.outputs import output
from robot_perception.teaching.pages.contents import Contents

ROW = 0.24
"""Height of a line of the graph, inches."""
WIDTH = 4.7
"""Width of the graph, inches: a telephone shows its letters at full size."""
REACH, FLAT = 1.35, 0.09
"""Width of the widest arc, and of one for each line that it spans, inches."""


@dataclass(frozen=True, slots=True)
class Path:
    """A way through the book for one aim.

    Parameters
    ----------
    name
        For whom it is.
    goals
        Chapters at which it aims; what these need comes before them.
    then
        Pages that follow.
    exercises
        Whether the exercises are counted.
    """

    name: str
    goals: tuple[str, ...]
    then: tuple[str, ...] = ()
    exercises: bool = True

    def stops(self, contents: Contents) -> tuple[str, ...]:
        """Return the pages of the path in their order."""
        return (*contents.before(self.goals), *self.then)

    def minutes(self, contents: Contents) -> float:
        """Return how long the path takes."""
        pages = contents.pages
        return sum(pages[s].minutes(exercises=self.exercises) for s in self.stops(contents))


PATHS = (
    Path("Maps and SLAM", ("loop_closing", "visual_slam", "map_localisation", "look_alikes")),
    Path("People around a robot", ("people_sensors", "people_fusion", "tutor_face")),
    Path("Trackers of pictures", ("pattern_tracking", "tutor_following", "arm_tracking")),
    Path("An engineer with data", ("monobot",), ("your_own_data",), exercises=False),
)


def named(contents: Contents, stem: str) -> str:
    """Return number and title of a page."""
    page = contents.pages[stem]
    return f"{page.number}. {page.title}" if page.number else page.title


def linked(contents: Contents, stem: str) -> str:
    """Return a link to a page, as HTML."""
    return f'<a href="{stem}.html">{escape(named(contents, stem))}</a>'


def hours(minutes: float) -> str:
    """Return a time in words: to half hours, from an hour on."""
    halves = round(minutes / 30)
    if halves < 2:
        return f"{5 * round(minutes / 5)} minutes"
    whole, half = divmod(halves, 2)
    return f"{whole}{' ½' if half else ''} hour{'' if halves == 2 else 's'}"


def paths(contents: Contents, ways: Sequence[Path] = PATHS) -> Shown:
    """Return the ways as a table: chapters in their order, with minutes, and the hours in all."""
    rows, lines = [], []
    for way in ways:
        stops = way.stops(contents)
        each = [round(contents.pages[s].minutes(exercises=way.exercises)) for s in stops]
        told = hours(way.minutes(contents))
        steps = " → ".join(
            f"{linked(contents, stop)} <small>{minutes}′</small>"
            for stop, minutes in zip(stops, each, strict=True)
        )
        without = "" if way.exercises else "<br><small>without exercises</small>"
        rows.append(
            f'<tr><th scope="row">{escape(way.name)}</th>'
            f'<td class="rp-text">{told}{without}</td><td class="rp-text">{steps}</td></tr>'
        )
        lines.append(f"{way.name}, {told}: {', '.join(named(contents, stop) for stop in stops)}")
    head = "".join(f'<th scope="col">{name}</th>' for name in ("For", "Takes", "Pages, minutes"))
    html = html_table("Ways through the book", "rp-paths", head, "".join(rows))
    return output(html, "\n".join(lines), "table.css")


def graph(contents: Contents) -> Shown:
    """Return the chapters as a drawing of links: an arc joins each one to what it needs."""
    lines: list[tuple[str | None, str]] = []
    for page in contents.chapters:
        if page.part not in [text for stem, text in lines if stem is None]:
            lines.append((None, page.part))
        lines.append((page.stem, named(contents, page.stem)))
    height = ROW * len(lines) + 0.1
    fig, ax = figure(width=WIDTH, height=max(height, 1.0))
    ax.set_position((0, 0, 1, 1))
    ax.set_axis_off()
    ax.set(xlim=(0, WIDTH), ylim=(height, 0))
    places = {stem: ROW * (k + 0.6) for k, (stem, _) in enumerate(lines) if stem}
    dot = REACH / 2 + 0.1
    for stem, y in places.items():
        for need in contents.direct(stem):
            above = places[need]
            wide = min(REACH, 2 * FLAT * (y - above) / ROW + 0.1)
            middle = dot, (above + y) / 2
            arc = Arc(middle, wide, y - above, theta1=90, theta2=270, linewidth=1.2)
            arc.set_edgecolor(MEANING["expected"])
            ax.add_patch(arc)
    ax.plot([dot] * len(places), list(places.values()), "o", color=MEANING["robot"], markersize=4)
    for k, (stem, text) in enumerate(lines):
        y = ROW * (k + 0.6)
        if stem is None:
            ax.text(dot + 0.12, y, text, va="center", fontsize=8.6, color=MEANING["expected"])
        else:
            ax.text(dot + 0.12, y, text, va="center", fontsize=9.0, url=f"{stem}.html")
    told = "; ".join(
        f"{named(contents, page.stem)} needs "
        + (", ".join(contents.pages[s].title for s in contents.direct(page.stem)) or "no other")
        for page in contents.chapters
    )
    svg = to_svg(fig).replace(
        ' role="img"', f' role="group" aria-label="Which chapter needs which. {escape(told)}."', 1
    )
    svg = re.sub(r'xlink:href="(\w+\.html)" target="_blank"', r'href="\1"', svg)
    return output(f'<div class="rp-graph">{svg}</div>', told.replace("; ", "\n"), "figure.css")
