"""Pictures as they come: every kind that a camera or a program writes."""

import struct
import zlib

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from robot_perception import datasets
from robot_perception.datasets import CorruptImage, images, pictures, read_image
from tests.datasets.formats.pictures import COLOUR, GREY, RNG
from tests.datasets.writing import encoded

UPRIGHT = {  # by the orientation of the EXIF standard: how the stored picture becomes upright
    1: lambda a: a,
    2: lambda a: a[:, ::-1],
    3: lambda a: a[::-1, ::-1],
    4: lambda a: a[::-1],
    5: lambda a: a.swapaxes(0, 1),
    6: lambda a: np.rot90(a, -1),
    7: lambda a: a[::-1, ::-1].swapaxes(0, 1),
    8: lambda a: np.rot90(a),
}
EXACT = {".png", ".bmp", ".tif", ".tiff", ".ppm"}


@pytest.mark.parametrize("capital", [False, True])
@pytest.mark.parametrize("ending", images.ENDINGS)
def test_pictures_of_every_ending_are_read(ending, capital, tmp_path):
    """In a folder, where none is named, and with what OpenCV reads as an oracle."""
    grey = ending in {".pgm", ".pbm", ".gif"}
    path = tmp_path / f"shot_1{ending.upper() if capital else ending}"
    stored = Image.fromarray(GREY if grey else COLOUR)
    stored = stored.convert("1") if ending == ".pbm" else stored
    stored.save(path, Image.registered_extensions()[ending])
    (found,) = datasets.read_images(tmp_path, colour=True)
    if ending != ".gif":  # some versions of OpenCV do not read it
        oracle = cv2.imread(str(path), cv2.IMREAD_COLOR)[..., ::-1]
        assert np.abs(found.astype(int) - oracle).max() <= (0 if grey or ending in EXACT else 4)
    assert Image.registered_extensions()[ending] in pictures.FORMATS
    assert datasets.picture_files(tmp_path) == ((path,), ())
    assert len(datasets.read_images(tmp_path, f"shot*{ending}")) == 1


@pytest.mark.parametrize("orientation", UPRIGHT)
@pytest.mark.parametrize("ending", [".jpg", ".png", ".tif", ".webp"])
def test_a_picture_is_turned_as_the_camera_was_held(ending, orientation, tmp_path):
    exif = Image.Exif()
    exif[0x0112] = orientation
    Image.fromarray(COLOUR).save(tmp_path / f"a{ending}", exif=exif, quality=95)
    Image.fromarray(COLOUR).save(tmp_path / f"b{ending}", quality=95)
    for colour in (False, True):
        found = read_image(tmp_path / f"a{ending}", colour=colour)
        plain = read_image(tmp_path / f"b{ending}", colour=colour)
        np.testing.assert_array_equal(found, UPRIGHT[orientation](plain))


MODES = {
    "1": (".png", lambda a: a.convert("1")),
    "L": (".png", lambda a: a.convert("L")),
    "LA": (".png", lambda a: a.convert("LA")),
    "P": (".png", lambda a: a.quantize(64)),
    "RGBA": (".png", lambda a: a.convert("RGBA")),
    "CMYK": (".jpg", lambda a: a.convert("CMYK")),
    "CMYK of TIFF": (".tif", lambda a: a.convert("CMYK")),
    "YCbCr of TIFF": (".tif", lambda a: a.convert("YCbCr")),
}


@pytest.mark.parametrize("mode", MODES)
def test_pictures_of_every_kind_of_eight_bits_are_read(mode, tmp_path):
    ending, turned = MODES[mode]
    stored = turned(Image.fromarray(COLOUR))
    stored.save(tmp_path / f"a{ending}")
    right = np.asarray(stored.convert("RGB"))
    found = read_image(tmp_path / f"a{ending}", colour=True)
    assert np.abs(found.astype(int) - right).max() <= (0 if ending == ".png" else 24)
    assert np.abs(found.astype(int) - right).mean() < 2
    assert read_image(tmp_path / f"a{ending}").shape == GREY.shape


@pytest.mark.parametrize("ending", [".png", ".tif", ".pgm"])
@pytest.mark.parametrize("colour", [False, True])
def test_of_sixteen_bits_the_upper_eight_are_taken(ending, colour, tmp_path):
    deep = RNG.integers(0, 2**16, (40, 60)).astype(np.uint16)
    deep[0, :2] = 0, 3
    path = tmp_path / f"a{ending}"
    cv2.imwrite(str(path), deep)
    found = read_image(path, colour=colour)
    np.testing.assert_array_equal(
        found, np.repeat(deep[..., None] >> 8, 3, 2) if colour else deep >> 8
    )
    np.testing.assert_array_equal(found, cv2.imread(str(path), int(colour)))
    for factor in (256, 257):  # eight bits that a program made longer
        clipped = np.where(np.median(GREY) > GREY, 0, GREY)
        cv2.imwrite(str(path), clipped.astype(np.uint16) * factor)
        np.testing.assert_array_equal(read_image(path), clipped)
    for dark in (np.zeros_like(deep), np.where(deep > 2**15, 65535, 0).astype(np.uint16)):
        cv2.imwrite(str(path), dark)  # a lens that is covered, and a mask
        np.testing.assert_array_equal(read_image(path), dark >> 8)


# ---- rows that are missing -----------------------------------------------------------------------


@pytest.mark.parametrize("size", [(7, 5), (8, 8), (33, 19), (1, 1), (3, 100)])
@pytest.mark.parametrize("mode", ["1", "L", "P", "RGB", "RGBA", "I;16"])
def test_whole_pngs_have_all_their_rows(size, mode, tmp_path):
    """Interlaced ones, too, put together here of the passes of the standard."""
    grey = RNG.integers(0, 256, size[::-1]).astype(np.uint8)
    deep = grey.astype(np.uint16) + 3
    stored = Image.fromarray(deep) if mode == "I;16" else Image.fromarray(grey).convert(mode)
    stored.save(tmp_path / "a.png")
    assert read_image(tmp_path / "a.png").shape == grey.shape
    rows = b"".join(
        b"\0" + grey[y::down, x::across][k].tobytes()
        for x, y, across, down in pictures.INTERLACED
        for k in range(grey[y::down, x::across].shape[0])
        if grey[y::down, x::across].size
    )
    head = struct.pack(">IIBBBBB", *size, 8, 0, 0, 0, 1)
    for cut in (0, 1):
        parts = ((b"IHDR", head), (b"IDAT", zlib.compress(rows[: len(rows) - cut])), (b"IEND", b""))
        content = b"".join(
            struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body))
            for name, body in parts
        )
        (tmp_path / "b.png").write_bytes(b"\x89PNG\r\n\x1a\n" + content)
        if cut:
            with pytest.raises(CorruptImage, match=r"b\.png: (no picture, or a|a) damaged"):
                read_image(tmp_path / "b.png")
        else:
            np.testing.assert_array_equal(read_image(tmp_path / "b.png"), grey)


@settings(max_examples=40, deadline=None)
@given(
    value=st.integers(0, 255),
    size=st.tuples(st.integers(1, 40), st.integers(1, 40)),
    progressive=st.booleans(),
    restarts=st.integers(0, 2),
    tail=st.sampled_from([b"", b"\0" * 9, b"\xff\xd8 a second picture \xff\xd9", b"ftyp" * 40]),
)
def test_whole_jpegs_of_one_colour_have_all_their_rows(
    value, size, progressive, restarts, tail, tmp_path_factory
):
    """And what telephones put behind a picture is none of it."""
    path = tmp_path_factory.mktemp("flat") / "a.jpg"
    flat = np.full((*size, 3), value, np.uint8)
    how = {"progressive": progressive, "quality": 90, "restart_marker_rows": restarts}
    path.write_bytes(encoded(flat, "JPEG", **how) + tail)
    assert np.abs(read_image(path, colour=True).astype(int) - flat).max() <= 3


def test_of_a_picture_with_a_preview_the_picture_is_read(tmp_path):
    """As telephones write it: two JPEG files in one."""
    small = Image.fromarray(COLOUR[::2, ::2].copy())
    Image.fromarray(COLOUR).save(tmp_path / "a.jpg", "MPO", save_all=True, append_images=[small])
    assert read_image(tmp_path / "a.jpg").shape == GREY.shape
