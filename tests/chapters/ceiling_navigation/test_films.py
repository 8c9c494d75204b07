"""The film of the chapter: what is drawn, and that it shows what its words tell."""

import numpy as np
import pytest

from robot_perception.book import ceiling_navigation as page
from robot_perception.chapters.ceiling_navigation import films
from robot_perception.chapters.ceiling_navigation.scene import plan


@pytest.fixture(scope="module")
def found():
    return page.comeback()


def test_a_frame_shows_picture_patterns_and_both_robots(found):
    every = len(found.driven) // 3
    for k, fig in enumerate(films.frames(found, every)):
        left, right = fig.axes
        assert left.images[0].get_array().shape == (240, 320)
        assert len(left.lines) == len(found.sightings[k * every])
        taught, keys, driven, true, estimated = right.lines
        assert len(taught.get_xdata()) == len(found.taught)
        assert len(keys.get_xdata()) == len(found.keys)
        assert len(driven.get_xdata()) == k * every + 1
        for line, pose in (
            (true, found.driven[k * every]),
            (estimated, found.estimated[k * every]),
        ):
            middle = line.get_xydata()[1:3].mean(axis=0)
            assert np.hypot(*(middle - pose[:2])) == pytest.approx(0.14, abs=0.01)
        assert f"{0.1 * k * every:.1f} s" in left.get_title(loc="left")


def test_the_windows_stand_on_what_is_tracked(found):
    fig = next(films.frames(found, len(found.driven)))
    for line, sighting in zip(fig.axes[0].lines, found.sightings[0].values(), strict=True):
        corners = line.get_xydata()
        np.testing.assert_allclose(corners[0], sighting[:2], atol=1e-9)
        away = np.hypot(*(corners[1] - corners[0]))
        heading = np.arctan2(*(corners[1] - corners[0])[::-1])
        assert away == pytest.approx(32 * sighting[3], rel=1e-6)
        assert np.cos(heading - sighting[2]) == pytest.approx(1)


def test_the_film_shows_what_its_words_tell(found):
    """Beside the path at first, on it after two metres, at its end in the end."""
    assert page.came_of(found.taught, found.driven, found.status)["fits"]
    off = np.hypot(*(found.driven[:, None, :2] - found.taught[:, :2]).transpose(2, 0, 1)).min(1)
    way = np.append(0, np.cumsum(np.hypot(*np.diff(found.driven[:, :2], axis=0).T)))
    assert off[0] > 0.03
    assert off[way > 2].max() < 0.1
    assert np.hypot(*(found.estimated - found.driven)[:, :2].T).max() < 0.2


def test_a_plan_shows_the_ceiling_where_it_is(found):
    shown = plan(found.ceiling, found.taught)
    points = found.taught[:, :2].mean(axis=0) + np.random.default_rng(4).uniform(-2, 2, (2000, 2))
    left, right, bottom, top = shown.extent
    rows, columns = shown.image.shape
    x, y = ((points - [left, top]) / [right - left, bottom - top] * [columns, rows]).T.astype(int)
    texels = np.round(found.ceiling.texels(points)).astype(int)
    true = found.ceiling.texture[texels[:, 1], texels[:, 0]].astype(float)
    assert np.corrcoef(true, shown.image[y, x].astype(float))[0, 1] > 0.7
