"""The claims of the chapter: the record, and what their findings must say."""

from robot_perception.chapters.visual_slam import maps
from tests.chapters.ledger import LedgerTests, quick, recorded


class TestLedger(LedgerTests):
    stem = "visual_slam"
    open_when_quick = frozenset({"map-10"})


def test_verdicts():
    assert {e.id: e.verdict for e in recorded().chapter("visual_slam").entries} == {
        "map-10": "reproduced",
        "map-50": "reproduced",
        "factorisation": "reproduced",
        "neff-resampling": "inconclusive",
        "erratum-neff": "refuted",
        "stable-landmarks": "reproduced",
        "mahalanobis-matches": "conditional",
        "mahalanobis-map": "not reproduced",
        "per-particle-association": "not reproduced",
    }


def test_one_particle_is_worse_than_the_wheels_and_ten_are_better():
    table = recorded()["map-10"].tables["errors"]
    one, wheels, ten = (table[row, "ATE (m)"] for row in ("M = 1", "wheels alone", "M = 10"))
    assert one.estimate > wheels.estimate > ten.high


def test_more_than_ten_particles_change_the_error_by_less_than_its_interval():
    table = recorded()["map-10"].tables["errors"]
    ten, hundred = (table[f"M = {m}", "ATE (m)"] for m in (10, 100))
    assert hundred.high > 0.5 * ten.estimate


def test_fifty_particles_draw_more_maps_right_than_ten_and_four_hundred_do_not():
    gains = [maps.more_right(recorded()[f"map-{n}"].tables["buildings"]) for n in (10, 50)]
    assert all(gain.low > 0 for gain in gains)
    evidence = recorded()["map-50"].evidence
    fifty, many = (evidence[f"maps that are right, M = {count}"] for count in (50, 400))
    assert fifty.overlaps(many)


def test_shrunk_variances_leave_less_error_and_raw_ones_do_not():
    evidence = recorded()["mahalanobis-map"].evidence
    over = "ATE, Mahalanobis, {} over Euclid to the mean".format
    shrunk, raw = evidence[over("shrunk")], evidence[over("raw")]
    assert shrunk.high < 1 < raw.high


def test_never_to_draw_is_worse_than_the_papers_rule():
    evidence = recorded()["neff-resampling"].evidence
    assert evidence["ATE, below M/2 over never, M = 10"].high < 1


def test_the_map_without_the_rule_of_stable_tracks_is_several_times_as_large():
    finding = quick("stable-landmarks")
    with_, without = (
        finding.evidence[f"landmarks {name}"].estimate for name in ("with the rule", "without")
    )
    assert 3 * with_ < without


def test_few_of_the_recognised_are_wrong():
    share = quick("map-10").evidence["wrong among the recognised, M = 10"]
    assert 0 < share.low < share.high < 0.15


def test_most_of_the_error_is_not_that_of_wrong_matches():
    """Told which landmark it is, the filter errs more than half as much."""
    assert recorded()["map-10"].evidence["ATE, landmarks told over recognised, M = 10"].low > 0.5


def test_few_draws_are_spared_unless_points_are_doubted():
    spared = recorded()["neff-resampling"].evidence
    assert spared["draws spared, below M/2, M = 50"].high < 2e-3
    assert spared["draws spared, below M/2, M = 50, points doubted"].low > 0.1


def test_with_names_of_its_own_a_particle_still_needs_the_wide_gate():
    evidence = recorded()["per-particle-association"].evidence
    assert evidence["ATE, each in its own gate over shared in the wide one"].low > 1


def test_the_path_is_best_with_points_of_more_than_two_frames():
    table = recorded()["stable-landmarks"].tables["rules"]
    errors = {row: table[row, "ATE (m)"].estimate for row in table.rows}
    assert min(errors, key=errors.get) == "more than 2"


def test_maps_of_particles_are_exact_to_eight_decimals():
    found = recorded()["factorisation"]
    assert found.value.high == found.evidence["largest relative difference of a variance"].high == 0
