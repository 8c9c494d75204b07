"""What is stored of recordings and long runs is what this code computes."""

import pytest

from robot_perception import chapters, datasets

STORED = (*chapters.recordings(), *chapters.states())
RENEW = "stored by other code: `robot-perception store --keys --only {}`"


@pytest.mark.parametrize("stored", STORED, ids=lambda stored: stored.store)
def test_what_is_stored_is_of_this_code(stored):
    recording = getattr(stored, "dataset", None)
    if recording is not None and datasets.find(recording) is None:
        assert stored._summary()["code"] == stored._code(), RENEW.format(stored.store)
        pytest.skip(f"{recording} is not on this computer")
    assert stored.is_current(), RENEW.format(stored.store)
