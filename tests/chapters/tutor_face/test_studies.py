"""The studies: worlds, and what they count, by law."""

from types import SimpleNamespace

import numpy as np
import pytest

from robot_perception.book import tutor_face as tutor
from robot_perception.chapters.tutor_face import recordings
from studies.rows import Rows, framed

RNG = np.random.default_rng


# Finding


def test_the_box_of_a_look_is_where_the_detector_has_the_face():
    some = [tutor.look(RNG(k), tutor.identity(k)) for k in range(12)]
    hits = [tutor.at_face(tutor.DETECTOR.find(image), truth) for image, truth in some]
    assert sum(hit is not None for hit in hits) >= 10


def test_a_lamp_that_does_not_move_changes_the_light_and_nothing_else():
    (one, box), (other, same) = (
        tutor.look(RNG(3), tutor.identity(1), lamp=lamp) for lamp in (0.0, 0.8)
    )
    assert (box == same).all()
    assert (one != other).any()


def test_a_detection_elsewhere_is_no_face():
    box = np.array([10.0, 10, 20, 20])
    assert tutor.at_face(np.zeros((0, 4)), box) is None
    assert tutor.at_face(np.array([[100.0, 100, 20, 20]]), box) is None
    assert tutor.at_face(np.array([[100.0, 100, 20, 20], [11, 10, 20, 20]]), box) == 1


def test_what_is_not_at_the_face_is_a_false_alarm_at_each_turn_to_either_side(monkeypatch):
    face, away = np.array([10.0, 10, 20, 20]), np.array([[100.0, 10, 20, 20], [10, 90, 20, 20]])
    turns, found = [], iter([np.vstack([face, away]), away[:1], np.zeros((0, 4))] * 20)

    def look(rng, who, *, turn):
        turns.append(np.degrees(turn))
        return None, face

    monkeypatch.setattr(tutor, "look", look)
    monkeypatch.setattr(tutor, "DETECTOR", SimpleNamespace(find=lambda image: next(found)))
    for person in range(7600, 7610):
        trial = tutor.detected.but(turns=(0, 30, 60), turned=5.0).trial(person=person)
        assert (trial["found"], trial["false"]) == ([True, False, False], [2, 1, 0])
    np.testing.assert_allclose(np.abs(turns), [5, 35, 65] * 10)
    assert 5 < (np.array(turns) > 0).sum() < 25


def test_rates_are_of_their_turn_and_tone():
    hits = {1: ([1, 0], 0), 2: ([1, 1], 0), 3: ([0, 0], 2)}
    trials = [
        {"person": k, "turn": [0, 45], "found": found, "false": [0, 0], "tone": tone}
        for k, (found, tone) in hits.items()
    ]
    rows = Rows(framed(trials), "person", {})
    turns, tones = tutor.by_turn(rows), tutor.by_tone(rows)
    assert turns["0", "found"].estimate == pytest.approx(2 / 3)
    assert turns["45", "found"].estimate == pytest.approx(1 / 3)
    assert list(tones.rows) == ["lightest", "third"]
    assert tones["lightest", "found"].estimate == 1
    assert tones["third", "found"].estimate == 0


# Recognising


def test_later_pictures_and_strangers_are_asked_and_named_as_the_space_says(monkeypatch):
    """A face that says whose it is and when it was taken, and a space that reads it."""
    times = range(tutor.ENROLLED + tutor.LATER)
    everyone = range(tutor.PEOPLE + tutor.STRANGERS)
    met = {(k, time): np.full((2, 2), 100.0 * k + time) for k in everyone for time in times}
    learnt, asked = [], []

    def recognise(face):
        k, time = divmod(int(face[0, 0]), 100)
        asked.append((k, time))
        named = k == tutor.PEOPLE or (k < tutor.PEOPLE and time != tutor.ENROLLED)
        who = f"person {k + 1}" if k != 1 else "person 1"
        return SimpleNamespace(nearest=who, name=who if named else None, from_space=3.0)

    def enrol(pictures, names, count):
        learnt.extend(zip(pictures[:, 0, 0] // 100, pictures[:, 0, 0] % 100, strict=True))
        return SimpleNamespace(recognise=recognise, mean=np.zeros((2, 2)))

    monkeypatch.setattr(tutor, "enrol", enrol)
    shares = tutor.gallery_shares(met, range(3), 5)
    assert set(learnt) == {(k, time) for k in range(3) for time in range(tutor.ENROLLED)}
    later = [(k, tutor.ENROLLED + time) for k in range(3) for time in range(tutor.LATER)]
    strangers = [(tutor.PEOPLE + k, t) for k in range(tutor.STRANGERS) for t in range(tutor.LATER)]
    assert asked == [*later, *strangers]
    assert shares["right"] == pytest.approx(2 / 3)
    assert shares["known"] == pytest.approx(2 / 3 * (tutor.LATER - 1) / tutor.LATER)
    assert shares["strangers"] == pytest.approx(1 / tutor.STRANGERS)
    assert shares["left"] == pytest.approx(3 / np.mean([100 * k + t for k, t in later]))


def test_shuffled_names_recognise_by_chance():
    rng, everyone = RNG(0), tutor.PEOPLE + tutor.STRANGERS
    person = rng.uniform(size=(everyone, 1, 8, 7))
    looks = person + 0.05 * rng.normal(size=(everyone, tutor.ENROLLED + tutor.LATER, 8, 7))
    met = {(k, time): look for k, of in enumerate(looks) for time, look in enumerate(of)}
    right = tutor.gallery_shares(met, range(3), 5)["right"]
    wrong = [tutor.gallery_shares(met, range(3), 5, RNG(k))["right"] for k in range(8)]
    assert right > 0.8 > 0.6 > np.mean(wrong)


def test_three_galleries_of_three_are_cut_from_ten(monkeypatch):
    asked = []

    def shares(met, people, eigenimages, shuffle):
        asked.append(people)
        return {"right": people[0]}

    monkeypatch.setattr(tutor, "gallery_shares", shares)
    every = tutor.PEOPLE * (tutor.ENROLLED + tutor.LATER) + tutor.STRANGERS * tutor.LATER
    monkeypatch.setattr(tutor, "faces", lambda *_: range(every * 3 // 4))
    found = tutor.recognised.trial(world=tutor.SCORED[0], gallery="three people", eigenimages=5)
    assert asked == [range(3), range(3, 6), range(6, 9)]
    assert found["right"] == 3
    assert found["missed"] == pytest.approx(0.25, abs=0.01)
    tutor.recognised.trial(world=tutor.SCORED[0], gallery="ten people", eigenimages=5)
    assert asked[3:] == [range(10)]


def drawn(light, **changes):
    """Return what a trial says of real people: who, whether a stranger, right, accepted."""
    return tutor.enrolled.but(**changes).trial(gallery=3, light=light)


def test_real_people_are_asked_for_other_pictures_than_those_enrolled(monkeypatch):
    """Every picture is of its own kind: of a known person four are left, of a stranger all ten."""
    asked, shown, whose = [], [], np.repeat(np.arange(8), 10)
    pictures = np.random.default_rng(0).normal(size=(80, 1, 30))
    monkeypatch.setattr(tutor, "pictures_in", lambda _: (whose, pictures))
    real = tutor.enrol

    def enrol(learnt, names, count):
        asked.append((learnt, names, count))
        space = real(learnt, names, count)

        def recognise(face):
            shown.append(face)
            return space.recognise(face)

        return SimpleNamespace(recognise=recognise)

    monkeypatch.setattr(tutor, "enrol", enrol)
    found = drawn("even")
    (learnt, names, count), *_ = asked
    assert (len(learnt), count, len(set(names))) == (30, tutor.EIGENIMAGES, 5)
    assert sorted(found["person"]) == list(range(8))
    assert found["stranger"].sum() == 3
    known = {f"person {k:.0f}" for k, new in zip(found["person"], found["stranger"], strict=True)
             if not new}  # fmt: skip
    assert known == set(names)
    assert (found["right"][found["stranger"] == 1] == 0).all()
    assert len(shown) == 5 * (10 - 6) + 3 * 10
    assert not {face.tobytes() for face in shown} & {face.tobytes() for face in learnt}


def test_light_from_the_side_is_in_one_level_and_in_no_other():
    counts = {light: len(tutor.pictures_in(light)[0]) for light in tutor.LIGHTS}
    assert counts == {"even": 200, "even, other people": 71, "from the side, too": 87}


def test_points_are_as_far_apart_as_the_pictures():
    faces = np.random.default_rng(0).uniform(size=(6, 9, 7))
    found = tutor.ORL_POINTS.result
    points = recordings.points([1] * 6, list("abcdef"), list(faces))
    assert isinstance(points, found)
    assert points.points.shape == (6, 5)
    ours = np.linalg.norm(points.points[:, None] - points.points, axis=-1)
    theirs = np.linalg.norm((faces[:, None] - faces).reshape(6, 6, -1), axis=-1)
    np.testing.assert_allclose(ours, theirs, atol=1e-12)


# The link


def link(rows, frames=8):
    """Return the faces of each picture: where they are, whom they are taken for, who they are."""
    seen = [[] for _ in range(frames)]
    for time, left, name, who in rows:
        taken = tutor.NAMES.get(name)
        seen[time].append((np.array([left, 50.0, 40, 40]), taken, who))
    return seen


def judged(monkeypatch, seen, rule):
    """Return what a trial says of a rule on given faces."""
    monkeypatch.setattr(tutor, "faces_seen", lambda film, frames: seen)
    study = tutor.linked.but(rules=(rule,), frames=len(seen))
    found = study.trial(film=tutor.SCORED[0])
    return found["alone"][0], found["has"][0]


def test_a_verified_link_waits_and_the_nearest_face_takes_over(monkeypatch):
    """Tutor 0 begins; from the third picture on tutor 1 stands where he stood."""
    seen = link([(0, 50.0, 0, 0), (1, 52.0, 0, 0), *[(t, 54.0, 1, 1) for t in range(2, 8)]])
    assert tutor.holders(seen, "verified").tolist() == [0, 0, *[tutor.NOBODY] * 6]
    assert tutor.holders(seen, "nearest").tolist() == [0, 0, *[1] * 6]
    assert judged(monkeypatch, seen, "verified") == (True, 1.0)
    assert not judged(monkeypatch, seen, "nearest")[0]


def test_a_robot_that_is_told_needs_no_recognition(monkeypatch):
    seen = link([(0, 50.0, 0, 0), *[(t, 50.0, None, 0) for t in range(1, 8)]])
    assert judged(monkeypatch, seen, "verified") == (True, 1 / 8)
    assert judged(monkeypatch, seen, "verified, told") == (True, 1.0)


def test_a_link_that_is_never_given_again_is_not_kept(monkeypatch):
    """The measure is one in which silence does not score."""
    seen = link([(0, 50.0, 0, 0), *[(t, 50.0, None, 0) for t in range(1, 8)]])
    monkeypatch.setattr(tutor, "faces_seen", lambda film, frames: seen)
    silent = tutor.linked.but(rules=("verified", "verified, told"), frames=8)
    found = silent.trial(film=tutor.SCORED[0])
    assert found["alone"] == [True, True]
    assert list(found["kept"]) == [False, True]


def test_a_link_that_another_face_has_is_not_kept(monkeypatch):
    seen = link([*[(t, 50.0, 0, 0) for t in range(7)], (7, 50.0, 0, 1)])
    monkeypatch.setattr(tutor, "faces_seen", lambda film, frames: seen)
    found = tutor.linked.but(rules=("verified",), frames=8).trial(film=tutor.SCORED[0])
    assert (list(found["kept"]), found["has"]) == ([False], [1.0])


def test_before_a_tutor_comes_there_is_no_link():
    seen = link([(3, 50.0, None, 2), (5, 90.0, 1, 1)])
    expected = [*[tutor.NO_LINK] * 5, 1, tutor.NOBODY, tutor.NOBODY]
    assert tutor.holders(seen, "verified").tolist() == expected


def test_when_the_first_link_has_ended_there_is_none():
    seen = link([(0, 50.0, 0, 0), *[(t, 90.0, 1, 1) for t in range(1, 8)]])
    held = tutor.holders(seen, "verified", patience=2).tolist()
    assert held == [0, *[tutor.NOBODY] * 2, *[tutor.NO_LINK] * 5]


def test_tutors_are_enrolled_by_as_many_pictures_each(monkeypatch):
    monkeypatch.setattr(tutor, "OCCASIONS", 4)
    monkeypatch.setattr(tutor, "EIGENIMAGES", 3)
    people = [tutor.identity(k) for k in (1, 2)]
    known = tutor.tutors_enrolled(101, people)
    assert [known.names.count(name) for name in known.people] == [4, 4]


# Bridging and steering


def test_only_misses_after_the_first_detection_count(monkeypatch):
    here = np.array([1.0, 0, 10, 10])
    away, truth = here + np.array([50.0, 0, 0, 0]), np.array([0.0, 0, 10, 10])
    boxes = [None, here, here, away, None]
    steps = [
        SimpleNamespace(
            truth=truth,
            whole=here[None] if k == 1 else away[None],
            box=box,
            last=here,
            searched=0.5,
            taken=here if k == 2 else None,
            work=10.0,
            most=30.0,
        )
        for k, box in enumerate(boxes)
    ]
    monkeypatch.setattr(tutor, "track", lambda *_: steps)
    found = tutor.bridged.trial(film=tutor.SCORED[0], scene="short")
    assert (found["missed"], found["filter"], found["last"]) == (3, 1, 3)
    assert (found["searched"], found["near"]) == (0.5, 0.4)
    assert (found["more"], found["neither"]) == (-2, 0)
    assert (found["seen"], found["taken"], found["work"]) == (1, 1, 50)
    assert found["most"] == 150
    idle = tutor.bridged.but(rival="nothing").trial(film=tutor.SCORED[0], scene="short")
    assert (idle["last"], idle["more"], idle["neither"]) == (0, 1, 2)


def test_places_of_a_cascade_are_counted_as_it_steps():
    """One size at a time: windows of 24 px in the picture that is made smaller."""
    image = np.zeros((60, 80), dtype=np.uint8)
    assert tutor.places(image, None, (24, 24)) == (60 - 23) * (80 - 23)
    assert tutor.places(image, None, (26, 27)) == pytest.approx((60 / 1.1 - 23) * (80 / 1.1 - 23))
    inside = np.array([-10.0, 20, 50, 30])  # of which 40 by 30 px are in the picture
    assert tutor.places(image, inside, (24, 24)) == (40 - 23) * (30 - 23)
    beyond = np.array([40.0, 30, 90, 90])  # to the right and below, too
    assert tutor.places(image, beyond, (24, 24)) == (40 - 23) * (30 - 23)
    assert tutor.places(image, np.array([0.0, 0, 20, 20])) == 0
    assert tutor.places(image) > tutor.places(image, None, (24, 40))


def test_detections_beside_the_face_lead_steered_particles_away():
    few = tutor.steered.but(frames=12)
    right, wrong = (
        few.but(beside=beside).trial(film=tutor.CHOOSING[1], filter="the detector alone")["lost"]
        for beside in (0.0, 2.0)
    )
    assert right < 0.2
    assert wrong > 0.8


def test_patience_and_reach_of_the_filter_are_those_that_are_asked_for(monkeypatch):
    made, empty = [], SimpleNamespace(frames=[], boxes=np.zeros((0, 1, 4)))

    def tracker(detector, rules):
        made.append(rules)
        return SimpleNamespace(start=lambda: None)

    monkeypatch.setattr(tutor, "FaceTracker", tracker)
    monkeypatch.setattr(tutor, "film_faces", lambda rng, frames, scene: empty)
    assert tutor.track(1, "short", patience=7, sigmas=2.0) == []
    assert (made[0].patience, made[0].sigmas) == (7, 2.0)


def test_a_face_is_lost_where_the_filter_that_is_named_hardly_covers_it(monkeypatch):
    """Of ten pictures the box is beside the face in three; the first one is told."""
    truth, asked = np.tile([50.0, 40, 30, 30], (10, 1)), []
    film = SimpleNamespace(frames=np.zeros((10, 8, 8, 3), np.uint8), boxes=truth[:, None])
    boxes = iter([*truth[:6], *truth[:3] + 25])

    def films(rng, frames, scene):
        asked.append((frames, scene.jumps))
        return film

    def filters(rules):
        asked.append(rules)
        return SimpleNamespace(
            start=lambda image, box, *, rng: None,
            step=lambda state, image, boxes_, *, rng: (SimpleNamespace(box=next(boxes)), None),
        )

    monkeypatch.setattr(tutor, "film_faces", films)
    monkeypatch.setattr(tutor, "FaceFilter", filters)
    monkeypatch.setattr(tutor, "DETECTOR", SimpleNamespace(find=lambda image: truth[:1] + 25))
    trial = tutor.steered.but(jumps=7.0, frames=10).trial(film=3, filter="condensation")
    assert trial["lost"] == pytest.approx(0.3)
    assert asked == [(10, 7.0), tutor.FILTERS["condensation"]]
    alone = tutor.steered.but(frames=10).trial(film=3, filter="the detector alone")
    assert alone["lost"] == pytest.approx(0.9)
