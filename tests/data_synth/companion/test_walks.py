"""People who walk, and films of one who is followed: what is true of them, by pixels."""

from dataclasses import replace

import numpy as np
import pytest

from data_synth.companion.faces import make_identity
from data_synth.companion.hall import RobotCamera
from data_synth.companion.walking import HIGH, TALL, Arm, Clothes, body_sprite, make_clothes
from data_synth.companion.walks import REGION, WalkScene, film_walk, person_box

RED, GREEN, BLUE = (0.8, 0.02, 0.02), (0.02, 0.7, 0.02), (0.02, 0.02, 0.8)
DRESS = Clothes(RED, GREEN, BLUE)


def of(sprite, channel):
    colours, cover = sprite[..., :3], sprite[..., 3] > 0.5
    others = [c for c in range(3) if c != channel]
    return cover & (colours[..., channel] > 3 * colours[..., others].max(axis=-1))


def rows(mask):
    found = np.flatnonzero(mask.any(axis=1))
    return found[0], found[-1]


@pytest.mark.parametrize("view", ["front", "back", "side"])
def test_a_person_is_as_tall_as_told_with_shirt_above_trousers(view):
    sprite = body_sprite(DRESS, view=view, height=230)
    top, bottom = rows(sprite[..., 3] > 0.5)
    assert HIGH * (230 - top) / 230 == pytest.approx(TALL, abs=0.06)
    assert bottom >= 224
    shirt, trousers = rows(of(sprite, 0)), rows(of(sprite, 2))
    assert shirt[0] < trousers[0]
    assert shirt[1] < trousers[1]
    waist = HIGH * (230 - shirt[1]) / 230
    assert 0.7 < waist < 1.0  # the sleeves reach below the belt


def test_a_step_moves_the_legs_and_standing_does_not():
    one, other = (body_sprite(DRESS, view="side", phase=p) for p in (np.pi / 2, 0.0))
    wide = [np.ptp(np.nonzero(of(s, 2)[-80:])[1]) for s in (one, other)]
    assert wide[0] > 1.8 * wide[1]
    still = [body_sprite(DRESS, walks=False, phase=p) for p in (0.0, 1.5)]
    np.testing.assert_array_equal(*still)


def test_a_raised_arm_reaches_its_wrist():
    arm = Arm(side=1, out=0.36, up=1.7)
    plain, raised = (body_sprite(DRESS, view="front", arm=a, height=230) for a in (None, arm))
    row, column = round(230 * (1 - arm.up / HIGH)), round((plain.shape[1] - 1) / 2 + 100 * arm.out)
    assert raised[row, column, 3] > 0.9
    assert plain[row, column, 3] < 0.1
    left = body_sprite(DRESS, view="front", arm=replace(arm, side=-1), height=230)
    assert left[row, raised.shape[1] - 1 - column, 3] > 0.9


def test_patterns_have_both_colours_and_plain_has_one():
    for pattern, second in (
        ("plain", False),
        ("stripes", True),
        ("checks", True),
        ("halves", True),
    ):
        sprite = body_sprite(replace(DRESS, pattern=pattern))
        assert of(sprite, 0).sum() > 500
        assert (of(sprite, 1).sum() > 500) == second


def test_light_scales_clothes():
    one, dim = body_sprite(DRESS), body_sprite(DRESS, light=0.5)
    shirt = of(one, 0)
    np.testing.assert_allclose(dim[shirt, 0], one[shirt, 0] / 2, atol=0.02)


def test_a_persons_box_is_that_of_head_and_trunk():
    camera = RobotCamera()
    box = person_box(camera, 2.5, 0.2)
    np.testing.assert_allclose(box[:2], camera.project(2.5, 0.2 - REGION[0], REGION[3]))
    end = box[:2] + box[2:]
    np.testing.assert_allclose(end, camera.project(2.5, 0.2 - REGION[2], REGION[1]))


@pytest.fixture(scope="module")
def films():
    kinds = ("none", "short, half", "short, whole", "long, half", "long, whole")
    return {
        kind: film_walk(np.random.default_rng(3), 70, WalkScene(kind, others=0)) for kind in kinds
    }


def hidden(film, share):
    return int((film.visible < share).sum())


def test_occlusions_are_as_long_and_as_whole_as_told(films):
    assert films["none"].visible.min() > 0.97
    assert not films["none"].passer.any()
    assert hidden(films["short, whole"], 0.45) in range(1, 9)
    assert hidden(films["long, whole"], 0.45) > 20
    assert films["long, whole"].visible.min() < 0.25
    assert 0.25 < films["long, half"].visible.min() < 0.7
    assert hidden(films["long, half"], 0.75) > 20
    assert 0.3 < films["short, half"].visible.min() < 0.9
    for film in films.values():
        assert film.visible[:10].min() > 0.95
        assert film.visible[-8:].min() > 0.95


def test_the_person_is_where_the_box_is():
    """What lies in the box stays the same while the wall beside it changes."""
    film = film_walk(np.random.default_rng(5), 40, WalkScene("none", others=0))
    assert film.frames.shape == (40, 240, 320, 3)
    assert film.boxes.shape == (40, 4)
    middles = film.boxes[:, :2] + film.boxes[:, 2:] / 2
    assert np.ptp(middles[:, 0]) > 5
    assert (np.abs(np.diff(middles, axis=0)) < 15).all()
    inside, beside = [], []
    for frame, box in zip(film.frames.astype(int), film.boxes, strict=True):
        inside.append(chest(frame, box))
        u, v, _, h = np.rint(box).astype(int)
        left = frame[v + h // 2 : v + h - 5, max(u - 45, 0) : max(u - 30, 1)]
        beside.append(np.median(left.reshape(-1, 3), axis=0))
    assert np.ptp(inside, axis=0).max() < 40
    assert np.abs(np.array(inside) - beside).max(axis=1).mean() > 20


def chest(frame, box):
    """Return the median colour of the middle of a trunk."""
    u, v, w, h = np.rint(box).astype(int)
    part = frame[v + h // 2 : v + h - 5, u + w // 3 : u + 2 * w // 3]
    return np.median(part.reshape(-1, 3), axis=0)


def test_the_one_who_passes_wears_the_same_clothes_if_told():
    scene, gaps = WalkScene("long, whole", others=0), []
    for alike in (False, True):
        film = film_walk(np.random.default_rng(12), 50, replace(scene, alike=alike))
        middle = int(film.visible.argmin())  # there the passer stands before the person
        person = chest(film.frames[2], film.boxes[2])
        gaps.append(np.abs(chest(film.frames[middle], film.passer[middle]) - person).max())
    assert gaps[0] > 40
    assert gaps[1] < 25


def test_light_changes_when_it_may(films):
    np.testing.assert_array_equal(films["none"].light, 1.0)
    film = film_walk(np.random.default_rng(3), 60, WalkScene("none", "changing", others=0))
    assert np.ptp(film.light.mean(axis=1)) > 0.15
    assert np.ptp(film.light[:, 0] / film.light[:, 2]) > 0.1


def test_the_same_seed_gives_the_same_film_and_others_walk_behind():
    one, other = (film_walk(np.random.default_rng(6), 40, WalkScene("none")) for _ in range(2))
    np.testing.assert_array_equal(one.frames, other.frames)
    empty = film_walk(np.random.default_rng(6), 40, WalkScene("none", others=0))
    np.testing.assert_array_equal(one.boxes, empty.boxes)
    assert np.abs(one.frames.astype(int) - empty.frames).max() > 60


def test_people_wear_different_things():
    rng = np.random.default_rng(0)
    worn = {make_clothes(rng) for _ in range(12)}
    assert len(worn) == 12
    assert len({clothes.pattern for clothes in worn}) >= 3
    assert body_sprite(DRESS, make_identity(rng)).shape == (260, round(260 * 1.7 / 2.3), 4)


@pytest.mark.parametrize(
    ("wrong", "text"),
    [
        (lambda: WalkScene("eclipse"), "occlusion must be one of none, short, half"),
        (lambda: WalkScene(light="dim"), "light must be"),
        (lambda: WalkScene(others=-1), "others must be"),
        (lambda: film_walk(np.random.default_rng(0), 5), "frames must be"),
        (lambda: replace(DRESS, shirt=(2.0, 0, 0)), "shirt must be"),
        (lambda: replace(DRESS, pattern="dots"), "pattern must be"),
        (lambda: Arm(side=0), "side must be"),
        (lambda: Arm(up=5.0), "up must be"),
        (lambda: body_sprite(DRESS, view="top"), "view must be"),
    ],
)
def test_what_is_wrong_is_named(wrong, text):
    with pytest.raises(ValueError, match=text):
        wrong()
