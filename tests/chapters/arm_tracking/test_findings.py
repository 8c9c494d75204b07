"""What the chapter tells a reader to find, in every state of its explorers."""

import numpy as np

from robot_perception.chapters.arm_tracking import bets, views
from robot_perception.chapters.arm_tracking.explorers import counted, cued
from tests.chapters.findings import ExplorerTests
from tests.chapters.ledger import recorded


class TestExplorers(ExplorerTests):
    explorers = (counted, cued)


def test_in_clutter_all_cues_hold_both_arms_and_contours_alone_hold_none():
    for setting in cued.parameters():
        if setting["behind"] == "clutter":
            held = cued.state(**setting).held
            if setting["way"] == "all cues":
                assert held == 2
            if setting["way"] == "contours only":
                assert held == 0


def test_at_least_one_arm_is_held_whatever_filter_and_particles():
    for setting in counted.parameters():
        assert counted.state(**setting).held >= 1
        if setting["particles"] >= 200:
            assert counted.state(**setting).held == 2


def test_presets_show_what_the_page_says():
    named = {name: cued.state(**{**cued.default, **v}) for name, v in cued.presets.items()}
    assert named["all cues"].held == 2
    assert named["no patches"].held < 2
    assert named["no motion"].held == 2


def test_the_film_of_pointing_holds_both_arms():
    state = views.pointing(16)
    assert state.held == 2
    assert np.ptp(state.sticks[:, 2, 1]) > 40, "one arm is lifted"


def test_the_right_answers_of_the_bets_are_what_is_computed():
    found = recorded()["clutter"].evidence
    losses = {way: found[f"all cues less {way}"].estimate
              for way in ("no patches", "no motion", "no stabiliser")}  # fmt: skip
    assert bets.CLUTTERED["right"] == "patches of colour and texture"
    assert losses["no patches"] == max(losses.values())
    assert bets.FILTERED["right"] == "hardly"
    ratio = recorded()["apf-400"].evidence["auxiliary over condensation, 400 particles"]
    assert 0.8 < ratio.estimate < 1.25


def test_words_say_how_far_off_the_wrists_are():
    words = cued.state(way="contours only", behind="clutter", time=40).words()
    assert "neither arm is held" in words
    assert "Picture 40" in words
