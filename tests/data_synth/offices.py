"""Offices with people, made once for all tests of a process."""

from functools import cache

import numpy as np

from data_synth.people import PeopleOffice, make_people_office


@cache
def office(seed: int, *, distractors: bool = True) -> PeopleOffice:
    """Return the office of a seed."""
    return make_people_office(rng=np.random.default_rng(seed), distractors=distractors)
