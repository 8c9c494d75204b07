"""Bodies: legs as a laser and sonars meet them, and all that a camera sees.

The skin ranges from light to dark as a pigment would make it: the logarithm of what comes back is
linear in its amount, and it takes more of the blue than of the red.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from data_synth._checks import array, flags, generator, instance, number
from data_synth.fisheye import Bodies, linear

LIGHT, DARK = (236, 200, 178), (98, 68, 54)
"""The lightest and the darkest skin, red, green and blue of 8 bits in white light."""

_HAIR = [(32, 26, 24), (62, 42, 30), (96, 68, 44), (150, 116, 76), (120, 62, 36), (150, 148, 146)]
_SHIRTS = [
    (54, 74, 120),
    (120, 40, 44),
    (60, 94, 66),
    (230, 230, 228),
    (40, 40, 44),
    (128, 132, 138),
]
_TROUSERS = [(40, 46, 70), (44, 44, 46), (92, 84, 70), (70, 72, 78)]
_PITCH = 0.9  # swing of an arm, rad for each metre of a leg's swing


@dataclass(frozen=True, slots=True)
class Person:
    """Looks of a person; all values are ours.

    Parameters
    ----------
    head
        Height of the middle of the head, m: 1.5 to 1.85.
    tone
        Skin, from 0 (light) to 1 (dark).
    stance
        Between the middles of the legs, m.
    leg
        Semi-axes of a leg at 30 cm, forward and sideways, m.
    pace
        Preferred speed, m/s.
    skirt
        Whether a long skirt hides the legs.
    long_hair
        Whether hair covers the sides of the head and the neck.
    hair, shirt, trousers
        Colours, red, green and blue of 8 bits.
    """

    head: float = 1.65
    tone: float = 0.2
    stance: float = 0.2
    leg: tuple[float, float] = (0.065, 0.055)
    pace: float = 1.1
    skirt: bool = False
    long_hair: bool = False
    hair: tuple[int, int, int] = _HAIR[1]
    shirt: tuple[int, int, int] = _SHIRTS[0]
    trousers: tuple[int, int, int] = _TROUSERS[0]

    def __post_init__(self) -> None:
        number("head", self.head, 1.5, 1.85)
        number("tone", self.tone, 0.0, 1.0)
        leg = array("leg", self.leg, (2,))
        if not ((leg >= 0.03) & (leg <= 0.12)).all():
            raise ValueError(f"leg must be from 0.03 to 0.12, got {self.leg}")
        number("stance", self.stance, 2 * leg[1], 0.5)
        number("pace", self.pace, 0.3, 1.6)
        instance("skirt", self.skirt, bool)
        instance("long_hair", self.long_hair, bool)
        for name in ("hair", "shirt", "trousers"):
            colour = array(name, getattr(self, name), (3,))
            if not ((colour >= 0) & (colour <= 255)).all():
                raise ValueError(f"{name} must be from 0 to 255, got {getattr(self, name)}")


def make_person(*, rng: np.random.Generator, skirt: bool | None = None) -> Person:
    """Return somebody drawn at random; one in ten wears a long skirt unless ``skirt`` says so."""
    generator(rng)
    if skirt is not None:
        instance("skirt", skirt, bool)
    drawn = rng.random() < 0.1
    wears = drawn if skirt is None else skirt
    radius = rng.uniform(0.052, 0.075)
    return Person(
        head=rng.uniform(1.5, 1.78),
        tone=rng.uniform(0.0, 1.0),
        stance=rng.uniform(0.17, 0.28),
        leg=(1.1 * radius, 0.92 * radius),
        pace=rng.uniform(0.7, 1.35),
        skirt=bool(wears),
        long_hair=bool(rng.random() < (0.8 if wears else 0.25)),
        hair=_HAIR[rng.integers(len(_HAIR))],
        shirt=_SHIRTS[rng.integers(len(_SHIRTS))],
        trousers=_TROUSERS[rng.integers(len(_TROUSERS))],
    )


def skin(tone: float) -> np.ndarray:
    """Return the colour (3,) of a skin: blue, green and red, shares of light."""
    number("tone", tone, 0.0, 1.0)
    return linear(LIGHT) ** (1 - tone) * linear(DARK) ** tone


def legs(
    person: Person, position: np.ndarray, heading: float, phase: float, swing: float
) -> np.ndarray:
    """Return the ellipses that a laser meets: two legs, or one skirt.

    Parameters
    ----------
    person
        Whose they are.
    position : (2,)
        Where the person is, m.
    heading
        Where the body faces, rad.
    phase
        Of the gait, rad.
    swing
        How far a leg swings forward and back, m.

    Returns
    -------
    (1 or 2, 5)
        Middle x and y, semi-axes ahead and sideways, m, and heading, rad.
    """
    instance("person", person, Person)
    position = array("position", position, (2,))
    heading, phase = number("heading", heading), number("phase", phase)
    swing = number("swing", swing, 0.0, 1.0)
    if person.skirt:
        ahead, side = 0.09 + 0.3 * swing + person.leg[0], person.stance / 2 + person.leg[1] + 0.03
        return np.array([[*position, ahead, side, heading]])
    forward = np.array([np.cos(heading), np.sin(heading)])
    left = np.array([-forward[1], forward[0]])
    step = swing * np.sin(phase) * forward
    return np.array(
        [
            [*(position + side * (person.stance / 2 * left + step)), *person.leg, heading]
            for side in (1, -1)
        ]
    )


def figures(
    people: Sequence[Person],
    positions: np.ndarray,
    headings: np.ndarray,
    gazes: np.ndarray,
    phases: np.ndarray,
    swings: np.ndarray,
    present: np.ndarray,
    light: np.ndarray,
) -> Bodies:
    """Return what a camera sees of people.

    Parameters
    ----------
    people
        Who they are.
    positions : (p, 2)
        Where they are, m.
    headings, gazes : (p,)
        Where bodies and faces are turned, rad.
    phases, swings : (p,)
        Of their gaits, rad and m.
    present : (p,)
        Who is there.
    light : (p,)
        The light at each.
    """
    if not isinstance(people, Sequence) or isinstance(people, str):
        raise TypeError(f"people must be a sequence, got {people!r:.60}")
    count = len(people)
    positions = array("positions (one for each of people)", positions, (count, 2))
    numbers = {"headings": headings, "gazes": gazes, "phases": phases, "swings": swings}
    headings, gazes, phases, swings = (array(k, v, (count,)) for k, v in numbers.items())
    light, present = array("light", light, (count,)), flags("present", present, count)
    parts: list[tuple] = []
    for k in np.flatnonzero(present):
        person = instance("people", people[k], Person)
        body = _figure(person, positions[k], headings[k], gazes[k], phases[k], swings[k])
        parts += [(*part, k, light[k]) for part in body]
    if not parts:
        empty = np.zeros((0, 3))
        return Bodies(empty, np.zeros((0, 3, 3)), empty, empty, *np.zeros((3, 0), dtype=int))
    centres, shapes, paint, hair, heads, owners, lights = map(np.array, zip(*parts, strict=True))
    return Bodies(centres, shapes, paint, hair, heads, owners, lights.astype(int))


def _figure(
    person: Person, at: np.ndarray, heading: float, gaze: float, phase: float, swing: float
) -> list[tuple]:
    """Ellipsoids of a person: middle, shape, colour, colour of the hair, kind of head."""
    parts = []
    top, flesh, hair = person.head, skin(person.tone), linear(person.hair)
    shirt, cloth = linear(person.shirt), linear(person.trousers)
    axes = _axes(heading)

    def add(ahead, side, up, size, paint, *, frame=axes, kind=0):
        centre = np.array([*at, 0.0]) + axes.T @ [ahead, side, up]
        parts.append((centre, frame / np.array(size)[:, None], paint, hair, kind))

    head = _axes(gaze)
    reach = axes @ head[0]  # the head sits a little before the neck
    nod = 0.03 * reach
    add(nod[0], nod[1], top, (0.1, 0.078, 0.125), flesh, frame=head, kind=1 + person.long_hair)
    add(0, 0, top - 0.15, (0.06, 0.058, 0.11), flesh)
    if person.long_hair:
        back = -0.055 * reach
        add(back[0], back[1], top - 0.1, (0.075, 0.085, 0.17), hair, frame=head)
    add(0, 0, top - 0.31, (0.11, 0.2, 0.13), shirt)
    add(0, 0, top - 0.5, (0.12, 0.175, 0.27), shirt)
    add(0, 0, top - 0.76, (0.13, 0.17, 0.18), cloth)
    if person.skirt:
        add(0, 0, top - 1.05, (0.19, 0.22, 0.5), cloth)
    for side in (1, -1):
        step = side * swing * np.sin(phase)
        if not person.skirt:
            add(0.5 * step, side * person.stance / 2, 0.45, (0.085, 0.08, 0.48), cloth)
        bend = -_PITCH * step
        limb = np.array(
            [[np.cos(bend), 0, np.sin(bend)], [0, 1, 0], [-np.sin(bend), 0, np.cos(bend)]]
        )
        out, down = 0.215, 0.33
        sway = np.sin(bend) * down
        add(-sway, side * out, top - 0.53, (0.05, 0.05, 0.31), shirt, frame=limb @ axes)
        add(-2 * sway, side * out, top - 0.87, (0.05, 0.03, 0.07), flesh)
    return parts


def _axes(heading: float) -> np.ndarray:
    """Rows: ahead, left and up."""
    cos, sin = np.cos(heading), np.sin(heading)
    return np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
