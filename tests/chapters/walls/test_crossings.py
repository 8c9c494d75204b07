"""Chains that cross themselves."""

from robot_perception.chapters.walls import crossings


def test_example_of_a_crossing_chain_goes_wrong_and_its_edges_are_named():
    example = crossings.crossing_example()
    assert example.differ
    assert 0 < len(example.edges) <= 4
