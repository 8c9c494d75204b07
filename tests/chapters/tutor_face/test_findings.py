"""What the chapter tells a reader to find, beyond what its explorer asserts itself."""

from scipy.stats import fisher_exact

from robot_perception.book import tutor_face as tutor


def test_faces_that_are_asked_for_are_none_of_those_enrolled():
    assert all(k >= tutor.PEOPLE or time >= tutor.ENROLLED for k, time in tutor.WHO.values())


# What the text says of the rows


def test_strangers_pass_and_more_eigenimages_show_more_of_a_face():
    table = tutor.by_count()
    assert table["20", "strangers"].low > 0.2
    left = [table[count, "left"].estimate for count in table.rows]
    assert left == sorted(left, reverse=True)


def test_light_from_the_side_decides_and_not_which_people():
    even, other, side = (tutor.real_faces.at(light=light) for light in tutor.LIGHTS)
    assert side.right.high < min(even.right.low, other.right.low)
    assert max(even.strangers.high, other.strangers.high) < side.strangers.low
    assert [row[0] for row in tutor.by_light().rows.values()] == [20, 8, 8]


def test_the_detector_looks_at_less_than_a_third_of_the_picture():
    assert tutor.bridged.rows().mean("searched", scene="short").high < 1 / 3


def test_who_began_the_link_has_it_more_often_verified_than_with_the_nearest_face():
    rows = tutor.linked.rows()
    verified, near, told = (
        rows.mean("has", rule=rule) for rule in ("verified", "nearest", "verified, told")
    )
    assert near.estimate < verified.low
    assert verified.high < told.low
    assert rows.rate("alone", rule="nearest").high < 0.5


def test_only_the_darkest_faces_are_found_less_often():
    frontal = tutor.detected.rows().where(turn=0)
    found = [frontal.of("found", tone=tone) for tone in range(6)]
    assert all(of.all() for of in found[:-1])
    dark, others = found[-1], sum(len(of) for of in found[:-1])
    assert fisher_exact([[dark.sum(), (~dark).sum()], [others, 0]]).pvalue < 0.001


def test_many_walking_particles_lose_the_face_more_often_than_few_that_are_steered():
    rows = tutor.steered.rows()
    steered, plain, _, alone = (rows.mean("lost", filter=name) for name in tutor.FILTERS)
    more = rows.difference("lost", ("filter", tuple(tutor.FILTERS)[2], "I-Condensation"))
    assert more.low > 0
    assert alone.high < plain.low
    assert alone.estimate > steered.estimate
