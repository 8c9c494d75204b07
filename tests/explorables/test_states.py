"""Explorers over masks and label images: every value kept, every pixel with its edges."""

import base64
import io
import re

import numpy as np
import pytest
from PIL import Image

from explorables.explore import explore, slider
from explorables.figures import figure, image_axes
from explorables.figures.output import PAGE_VARIABLE
from explorables.states import WEBP, pack, render

ALT = "Classes of a picture, one colour for each class."
PALETTE = np.array([[30, 60, 110], [20, 130, 135], [215, 150, 40]], np.uint8)


def classes(seed):
    """Return a label image in colours."""
    return PALETTE[np.random.default_rng(seed).integers(0, 3, (24, 32))]


def made(draw=classes, **options):
    """Return an explorer of label images."""
    return explore(draw, alt=ALT, seed=slider("Seed", [0, 1, 2], 1), **options)


def pixels(data):
    """Return the pixels of a WebP image."""
    return np.asarray(Image.open(io.BytesIO(data)))


@pytest.mark.parametrize("effort", [0, 4])
def test_every_value_is_kept_where_it_is_asked(effort):
    exact = made(lossless=True).frame(seed=2, effort=effort)
    assert exact.mime == WEBP
    assert (pixels(exact.data) == classes(2)).all()
    assert (pixels(made().frame(seed=2).data) != classes(2)).any()


@pytest.mark.parametrize("page", ["0", "1"])
def test_pixels_keep_their_edges_where_it_is_asked(monkeypatch, page):
    monkeypatch.setenv(PAGE_VARIABLE, page)
    for pixelated in (False, True):
        explorer = made(pixelated=pixelated)
        bundle = explorer._repr_mimebundle_()
        html = bundle["text/html"]
        assert ('<figure class="rp-figure rp-pixelated">' in html) == pixelated
        assert ("rp-pixelated" in explorer.spec["figure"]) == pixelated


def test_the_stored_default_is_the_exact_image(monkeypatch):
    monkeypatch.setenv(PAGE_VARIABLE, "1")
    html = made(lossless=True)._repr_mimebundle_()["text/html"]
    default = base64.b64decode(re.search(r'<img [^>]*base64,([^"]*)"', html)[1])
    assert (pixels(default) == classes(1)).all()


@pytest.mark.parametrize("option", ["pixelated", "lossless"])
def test_figures_are_not_made_of_pixels(option):
    with pytest.raises(TypeError, match="pixelated and lossless are for a draw that returns"):
        made(lambda seed: image_axes(classes(seed))[0], **{option: True})


def test_states_are_the_same_bytes_at_any_time(monkeypatch):
    fig, _ = figure()
    frames = [render(fig, "An empty drawing.")]
    before = pack(frames)
    monkeypatch.setattr("time.time", lambda: 1e9)
    assert pack(frames) == before
