"""The studies: trackers on a drawn head, measures by law, work as enumeration gives it."""

from types import SimpleNamespace

import numpy as np
import pytest

from robot_perception.appearance import head_ellipse
from robot_perception.appearance.colour_spaces import Binning
from robot_perception.appearance.head_ellipse import Ellipse, HeadTracker
from robot_perception.book import head_tracking as heads
from studies.intervals import exact
from studies.rows import Rows, framed

FRAMES, SIZE = 12, (80, 60)


def drawn():
    """Return frames of a coloured ellipse that moves, its boxes and its masks."""
    rows, columns = np.arange(SIZE[1])[:, None], np.arange(SIZE[0])
    frames = np.full((FRAMES, SIZE[1], SIZE[0], 3), (90, 120, 150), dtype=np.uint8)
    boxes = np.array([[30.0 + 2 * k, 30, 10, 12] for k in range(FRAMES)])
    masks = np.zeros(frames.shape[:3], dtype=bool)
    for k, (u, v, a, b) in enumerate(boxes):
        masks[k] = ((columns - u) / a) ** 2 + ((rows - v) / b) ** 2 <= 1
        frames[k][masks[k]] = (210, 140, 110)
        frames[k][masks[k] & (rows < v - 6)] = (60, 40, 30)
    return frames, boxes, masks


def shared(ellipses, truth):
    return np.array([*heads.overlaps(ellipses, truth)])


# Who follows


def test_trackers_follow_a_drawn_head():
    frames, boxes, masks = drawn()
    ellipse, hair = heads.start(frames[0], boxes[0])
    assert (ellipse.u, ellipse.v, ellipse.half_width) == (30, 30, 10)
    assert masks[0][hair].all()
    assert hair.any()
    assert (np.nonzero(hair)[0] < 30 - 0.6 * 12).all()
    widths = np.full(FRAMES, 10.0)
    for name in ("adapted", "fixed", "one view", "RGB, some 800"):
        found = heads.follow(frames, boxes[0], widths, **heads.TRACKERS[name])
        assert shared(found, masks).min() > 0.7, name
    assert shared(heads.camshift(frames, boxes[0]), masks)[0] == 1


def models(monkeypatch, **rules):
    """Return the model with which a tracker of the page begins, and its rules."""
    frames, boxes, _ = drawn()
    seen = []

    class Still(HeadTracker):
        def step(self, state, image, *, half_width=None):
            seen.append((state.model, self.rules, half_width))
            return state, None

    monkeypatch.setattr(heads, "HeadTracker", Still)
    heads.follow(frames[:2], boxes[0], [9.0, 11.0], **rules)
    return seen[0]


def test_models_of_one_and_of_two_views_have_the_same_mass(monkeypatch):
    for mass in (1.0, 2.0):
        one, two = (models(monkeypatch, views=views, mass=mass)[0] for views in (1, 2))
        assert one.sum() == pytest.approx(mass)
        assert two.sum() == pytest.approx(mass)
        assert np.abs(one - two).sum() > 0.1 * mass  # the second view is hair


def test_the_second_view_has_the_weight_of_the_first_and_is_hair(monkeypatch):
    one = models(monkeypatch, views=1, mass=1.0)[0]
    more = models(monkeypatch, views=2, mass=2.0)[0] - one
    assert more.max() == pytest.approx(1)  # all of it of one colour
    assert np.count_nonzero(np.abs(more) > 1e-9) == 1


def test_a_step_is_told_the_size_of_its_own_frame_and_the_rules_that_are_named(monkeypatch):
    _, rules, width = models(monkeypatch, rate=0.5, gate=0.1)
    assert (rules.rate, rules.gate, rules.measure) == (0.5, 0.1, "shares")
    assert width == 11.0


def test_only_those_that_are_named_so_give_up_or_are_fixed():
    for name, rules in heads.TRACKERS.items():
        assert ("gives_up" in rules) == name.endswith("gives up")
    assert heads.TRACKERS["fixed"]["rate"] == heads.TRACKERS["one view, fixed"]["rate"] == 0
    assert heads.TRACKERS["adapted"] == {}
    assert heads.TRACKERS[heads.ALWAYS] == {"rate": 0.02, "gate": 0.0}
    assert heads.TRACKERS[heads.FAST] == {"rate": 0.1, "gate": 0.4}
    assert heads.TRACKERS["one view, fixed, mass of one"] == {"rate": 0, "views": 1, "mass": 1}


def test_a_size_that_is_searched_is_not_told_and_rgb_may_be_coarser(monkeypatch):
    asked = []
    monkeypatch.setattr(heads, "follow", lambda frames, box, widths, **rules: asked.append(
        (widths, rules)))  # fmt: skip
    shown = SimpleNamespace(frames=None, ellipses=[None])
    for name, rgb in (("size by highest score", None), ("RGB, some 800", (2, 2, 2)),
                      ("opponent, some 800", (2, 2, 2))):  # fmt: skip
        heads.track(shown, name, 7, rgb)
    assert asked[0] == (None, {"measure": "printed", "size": "score"})
    assert (asked[1][0], asked[1][1]["bins"]) == (7, (2, 2, 2))
    assert asked[2][1]["bins"] == (16, 16, 8)


@pytest.mark.parametrize(
    ("space", "bins", "reached"),
    [
        (space, bins[space == "RGB"], reached)
        for bins, reaches in zip(
            heads.CELLS.values(), ((818, 810), (2186, 2197), (4176, 4096)), strict=True
        )
        for space, reached in zip(("opponent", "RGB"), reaches, strict=True)
    ],
)
def test_colours_of_bytes_reach_so_many_cells(space, bins, reached):
    binning = Binning(space, bins)
    seen = np.zeros(binning.count, dtype=bool)
    byte = np.arange(256, dtype=np.uint8)
    for red in byte:
        colours = np.stack(np.meshgrid(red, byte, byte), axis=-1).reshape(256, 256, 3)
        seen[binning.index(colours)] = True
    assert seen.sum() == reached


# Measures


def test_overlap_of_the_truth_is_one_and_of_elsewhere_none():
    _, boxes, masks = drawn()
    for shift, expected in ((0, 1.0), (30, 0.0)):
        np.testing.assert_array_equal(shared(np.add(boxes, [shift, 0, 0, 0]), masks), expected)


def test_overlap_counts_the_area_of_both():
    _, boxes, masks = drawn()
    for factor in (0.5, 2.0):
        np.testing.assert_allclose(shared(boxes * [1, 1, factor, 1], masks), 0.5, atol=0.05)


def test_distances_give_the_size_of_the_frame_before_with_their_errors(monkeypatch):
    monkeypatch.setattr(heads, "start", lambda *_: (SimpleNamespace(half_width=20), None))
    shown = SimpleNamespace(frames=[0], ellipses=[0], depth=np.array([1.0, 2.0, 4.0]))
    np.testing.assert_allclose(heads.sizes(shown, np.zeros(3)), [20, 20, 10])
    np.testing.assert_allclose(heads.sizes(shown, np.array([0, 0.25, 0])), [20, 16, 10])


def filmlike(visible=(), yaw=()):
    """Return a film that is nothing but how much of the head is seen, and where it looks."""
    seen, turned = np.ones(heads.FRAMES), np.zeros(heads.FRAMES)
    for k in visible:
        seen[k] = 0.4
    for k in yaw:
        turned[k] = -3.0
    return SimpleNamespace(visible=seen, yaw=turned)


def test_frames_are_scored_that_show_the_head_after_it_was_hidden_and_from_behind():
    seen, after, behind = heads.parts(filmlike(visible=(50, 51, 90), yaw=(51, 60, 61)))
    assert np.flatnonzero(~seen).tolist() == [50, 51, 90]
    assert np.flatnonzero(after).tolist() == [k for k in range(52, 150) if k != 90]
    assert np.flatnonzero(behind).tolist() == [60, 61]


def test_where_nobody_hides_it_a_quarter_is_left_out_and_a_face_is_scored_whole():
    seen, after, behind = heads.parts(filmlike())
    assert seen.all()
    assert behind.all()
    assert np.flatnonzero(after)[0] == 150 // 4


def test_a_trial_tells_of_each_tracker_what_it_misses(monkeypatch):
    shown = filmlike(visible=(100,), yaw=(120, 121))
    iou = np.full(heads.FRAMES, 0.5)
    iou[[10, 100, 110, 120]] = 0.1  # missed: before, while hidden, after, from behind
    for name, gives in {"filmed": shown, "sizes": None, "insides": None}.items():
        monkeypatch.setattr(heads, name, lambda *_, gives=gives: gives)
    monkeypatch.setattr(heads, "track", lambda shown, name, widths, rgb: name)
    monkeypatch.setattr(heads, "overlaps", lambda name, _: iou if name == "a" else iou * 0)
    found = heads.followed.but(trackers=("a", "b")).trial(film=1, scene=heads.CROWD)
    assert found["tracker"] == ("a", "b")
    np.testing.assert_allclose(found["missed"], [3 / 149, 1])
    np.testing.assert_allclose(found["missed after"], [2 / 49, 1])
    np.testing.assert_allclose(found["overlap"], [(146 * 0.5 + 0.3) / 149, 0])
    np.testing.assert_allclose(found["overlap behind"], [0.3, 0])


def test_a_dry_head_loses_nothing_and_what_shines_costs_brightness_first():
    dry = heads.shone.but(sweats=0.0).trial(film=3001)
    assert np.all(np.array(dry["lost"]) == 0)
    wet = heads.shone.but(bins=(16, 16, 1), rgb=(1, 1, 16)).trial(film=3001)
    lost = np.array(wet["lost"]).reshape(3, 2)
    assert wet["space"][:2] == ["opponent", "RGB"]
    assert (np.ptp(lost, axis=0) == 0).all()  # the same cells three times
    assert (lost[:, 1] > lost[:, 0]).all()


# What claims say of rows


def rows(**values):
    """Return rows of three films in which a tracker of a scene has a value of each measure."""
    measures = "missed", "missed after", "overlap", "overlap behind"
    parts = [
        {"film": film, "scene": scene, "tracker": [*of]}
        | {name: np.array([*of.values()], dtype=float) + 0.001 * film for name in measures}
        for film in range(3)
        for scene, of in values.items()
    ]
    return Rows(framed(parts), "film", {})


def test_gains_have_their_sign_and_are_of_their_scene():
    two = rows(**{heads.LIGHT: {"a": 0.2, "b": 0.5}, heads.CROWD: {"a": 0.4, "b": 0.3}})
    assert heads.spared(two, "a", "b", heads.LIGHT).estimate == pytest.approx(0.3)
    assert heads.spared(two, "a", "b", heads.CROWD).estimate == pytest.approx(-0.1)
    assert heads.among(rows(other={"a": 1}), heads.LIGHT).levels("scene") == ("other",)


def test_the_space_is_compared_over_all_numbers_of_cells():
    values = dict(zip(heads.COUNTED, (0.5, 0.6, 0.6, 0.6, 0.9, 0.6), strict=True))
    gain = heads.over_cells(rows(**{heads.LIGHT: values}))
    assert gain.estimate == pytest.approx((-0.1 + 0 + 0.3) / 3)


def test_the_second_view_is_worth_what_it_gains_at_the_mass_at_which_it_gains_less():
    names = ("fixed", "one view, fixed", "fixed, mass of one", "one view, fixed, mass of one")
    value = heads.histogram_bimodal.value
    for values, least in (((0.9, 0.5, 0.7, 0.6), 0.1), ((0.6, 0.5, 0.9, 0.6), 0.1)):
        two = rows(**{heads.TURNS: dict(zip(names, values, strict=True))})
        assert value(two).estimate == pytest.approx(least)


@pytest.mark.parametrize(
    ("passing", "words"),
    [
        ((0.3, 0.2, 0.3), "others pass"),
        ((0.4, 0.3, 0.3), "others pass, and the threshold is 0.5 or more"),
        ((0.4, 0.4, 0.3), "others pass, and the threshold is 0.8"),
        ((0.3, 0.3, 0.4), None),
    ],
)
def test_a_condition_of_the_threshold_holds_at_each_that_it_names(passing, words):
    names = heads.THRESHOLDS.values()
    crowd = {heads.ALWAYS: 0.4} | dict(zip(names, passing, strict=True))
    claim, alone = heads.histogram_threshold, dict.fromkeys((heads.ALWAYS, *names), 0.2)
    some = rows(**{heads.CROWD: crowd, heads.TURNS: alone})
    assert [c.text for c in claim.compute(some, exact(0.0)).conditions] == (
        [words] if words else []
    )
    helped = rows(**{heads.CROWD: crowd, heads.TURNS: alone | {heads.ALWAYS: 0.4}})
    assert not any(c.needed for c in claim.compute(helped, exact(0.0)).conditions)


# Adjacent ellipses


def test_what_the_tracker_carries_is_the_full_count_but_not_as_printed():
    for printed, expected in ((False, 9), (True, 0)):
        study = heads.carried.but(radius=1, printed=printed)
        for half_width in (5, 20):
            found = study.trial(place=1, half_width=half_width)
            assert found["same"] == expected
            assert found["candidates"] == (1 if printed else 9)


def test_the_claim_is_about_the_trackers_own_count(monkeypatch):
    def lazy(index, left, top, across, down, most, common):
        common[:] = 0

    monkeypatch.setattr(head_ellipse, "_slide", lazy)
    found = heads.carried.but(radius=1).trial(place=0, half_width=5)
    assert found["same"] < found["candidates"]


def test_a_step_aside_changes_two_pixels_a_row():
    changed = 2 * (2 * int(1.2 * 20) + 1)
    pixels, found = Ellipse(0, 0, 20).pixels, heads.saved.trial(half_width=20)
    assert found["carried"] == pixels / changed
    assert found["summed"] == (pixels + 818) / (changed + 818)
    assert 2.4 < found["summed"] < 2.6


def test_additions_are_those_of_the_masks():
    size, half_width, radius = (60, 60), 6, 2
    before, u = Ellipse(28, 28, half_width).mask(size), 28
    steps = before.sum()
    for row in range(2 * radius + 1):
        for column in range(2 * radius + 1):
            if row or column:
                u += 0 if column == 0 else 1 - 2 * (row % 2)
                now = Ellipse(u, 28 + row, half_width).mask(size)
                steps += (now != before).sum()
                before = now
    assert heads.additions(half_width, radius) == (25 * before.sum(), steps)
    cells = 818
    assert heads.additions(20, 8, cells) == tuple(n + 17**2 * cells for n in heads.additions(20, 8))


# A real head


def test_the_real_head_is_followed_from_its_first_frame_and_from_many(tmp_path, monkeypatch):
    frames, boxes, _ = drawn()
    monkeypatch.setattr(heads, "LONG", 6)
    monkeypatch.setattr(heads, "APART", 3)
    monkeypatch.setattr(heads, "SHOWN_GIRL", (0, 11))

    class Pictures(list):
        numbers = range(FRAMES)

    corners = boxes * [1, 1, 2, 2]
    monkeypatch.setattr(heads, "read_images", lambda *_, colour: Pictures(frames))
    told = SimpleNamespace(centres=boxes[:, :2], boxes=corners)
    monkeypatch.setattr(heads, "read_boxes", lambda path, numbers: told)
    found = heads.followed_girl(tmp_path)
    assert found.variants == (*heads.ON_GIRL, "CamShift")
    assert found.iou.shape == (7, FRAMES)
    assert found.starts.tolist() == [0, 3, 6]
    assert found.missed.shape == (7, 3)
    np.testing.assert_allclose(found.marked, boxes)
    slow = found.variants.index("fixed")
    assert (found.iou[slow] > 0.5).all()
    assert (found.missed[slow] == 0).all()
