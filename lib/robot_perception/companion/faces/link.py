"""The link between a robot and the person who began it, kept by asking again who that is."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Annotated, final

import numpy as np
from jaxtyping import Float

from robot_perception import checks
from robot_perception.companion.boxes import check_box
from robot_perception.companion.faces.eigenfaces import Eigenfaces
from robot_perception.fields import Positive, checked, from_to, one_of

__all__ = [
    "Link",
    "LinkInfo",
    "LinkRules",
    "SeenFace",
    "keep_link",
    "same_descriptor",
    "same_name",
]


@final
@dataclass(frozen=True, eq=False, slots=True)
class SeenFace:
    """A face in a picture, and who it is taken for.

    Parameters
    ----------
    box : (4,)
        Left, top, width and height, px.
    name
        Whom the recogniser takes it for; ``None`` for a stranger.
    descriptor : (k,), optional
        Whatever the recogniser describes it by.
    """

    box: Annotated[Float[np.ndarray, " 4"], check_box]
    name: str | None
    descriptor: Float[np.ndarray, " k"] | None = None
    __post_init__ = checked


@final
@dataclass(frozen=True, eq=False, slots=True)
class Link:
    """State of the link between the robot and a tutor.

    Parameters
    ----------
    name
        The tutor who began it.
    face
        As last seen.
    missed
        For how many pictures that face has not been verified.
    """

    name: str
    face: SeenFace
    missed: Annotated[int, from_to(0)] = 0
    __post_init__ = checked


@final
@dataclass(frozen=True, slots=True)
class LinkRules:
    """Rules by which a link goes on and ends.

    Parameters
    ----------
    policy
        ``"verified"``: the face must be verified as that of the tutor who began, the paper's rule.
        ``"nearest"``: the face that is nearest to the last one is taken, whoever it is, as by a
        tracker. ``"largest"``: in each picture the largest face of any authorised tutor has the
        link, which is what the paper wants to avoid.
    patience
        Pictures without the face after which the link ends, and another tutor may begin one.
    reach
        How far the face may be from its last place, in sides of a face for each picture since then
        and one more; ours.
    """

    policy: Annotated[str, one_of("verified", "nearest", "largest")] = "verified"
    patience: Annotated[int, from_to(0, 10**6)] = 30
    reach: Positive = 1.0
    __post_init__ = checked


@final
@dataclass(frozen=True, slots=True)
class LinkInfo:
    """Decisions of one step.

    Parameters
    ----------
    held
        Which of the faces has the link in this picture; ``None`` if none is seen or verified.
    began, ended
        Whether a link began or ended in this picture.
    """

    held: int | None
    began: bool = False
    ended: bool = False


def same_name(link: Link, face: SeenFace) -> bool:
    """Tell whether a face is recognised as the tutor who began the link."""
    checks.instance("link", link, Link)
    return checks.instance("face", face, SeenFace).name == link.name


def same_descriptor(known: Eigenfaces) -> Callable[[Link, SeenFace], bool]:
    """Return what tells whether a face has the descriptor of the tutor who began the link.

    It asks about one person, and not who of all the face is: whether the descriptor is as close to
    one of that tutor's in the gallery as its threshold accepts.

    Parameters
    ----------
    known
        The gallery that described the faces.

    Returns
    -------
    function
        Of the link and a face; a face without a descriptor is nobody's, raises `ValueError` if the
        link's tutor is not in the gallery.
    """
    checks.instance("known", known, Eigenfaces)
    whose = np.array(known.names)

    def verify(link: Link, face: SeenFace) -> bool:
        mine = whose == checks.instance("link", link, Link).name
        if not mine.any():
            raise ValueError(f"link must be of somebody in the gallery, got {link.name!r}")
        if checks.instance("face", face, SeenFace).descriptor is None:
            return False
        return bool(known.distances(face.descriptor)[mine].min() <= known.most_distance)

    return verify


def keep_link(
    link: Link | None,
    faces: Sequence[SeenFace],
    rules: LinkRules | None = None,
    *,
    verify: Callable[[Link, SeenFace], bool] = same_name,
) -> tuple[Link | None, LinkInfo]:
    """Return the link after a picture.

    Parameters
    ----------
    link
        Before it; ``None`` if there is none.
    faces
        All faces in the picture.
    rules
        The policy and its numbers.
    verify
        Function of the link and a face that tells whether it is still the same person; by default
        by the name that the recogniser gives.

    Returns
    -------
    Link or None
        The largest face of a tutor begins one.
    LinkInfo

    References
    ----------
    Section III, "Face tracking": the descriptor of the selected user verifies that the link is kept
    with the user who initiated it.
    """
    rules = LinkRules() if rules is None else checks.instance("rules", rules, LinkRules)
    faces = checks.instances("faces", tuple(checks.iterable("faces", faces)), SeenFace)
    checks.instance("verify", verify, Callable)
    sizes = np.array([face.box[2] * face.box[3] for face in faces])
    tutors = [k for k, face in enumerate(faces) if face.name is not None]
    largest = max(tutors, key=lambda k: sizes[k]) if tutors else None
    if link is not None:
        checks.instance("link", link, Link)
    if link is None:
        if largest is None:
            return None, LinkInfo(None)
        face = faces[largest]
        return Link(str(face.name), face), LinkInfo(largest, began=True)
    if rules.policy == "largest":
        held = largest
    else:
        near = [k for k, face in enumerate(faces) if _apart(link, face) <= rules.reach]
        if rules.policy == "verified":
            near = [k for k in near if checks.flag("verify(link, face)", verify(link, faces[k]))]
        held = min(near, key=lambda k: _apart(link, faces[k])) if near else None
    if held is not None:
        return Link(link.name, faces[held]), LinkInfo(held)
    if link.missed >= rules.patience:
        return None, LinkInfo(None, ended=True)
    return Link(link.name, link.face, link.missed + 1), LinkInfo(None)


def _apart(link: Link, face: SeenFace) -> float:
    """Return how far a face is from the last one, in sides for each picture since then."""
    middles = [box[:2] + box[2:] / 2 for box in (link.face.box, face.box)]
    away = float(np.hypot(*(middles[1] - middles[0])))
    return away / (float(link.face.box[2]) * (link.missed + 1))
