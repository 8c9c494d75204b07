"""Calibrations of stereo cameras, by the names that KITTI, OpenCV, ROS and Kalibr give them."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple
from xml.etree import ElementTree

import numpy as np
from jaxtyping import Float

from robot_perception import checks
from robot_perception.datasets.images import first
from robot_perception.datasets.logs import CorruptLog, Lines, ReadReport, are_numbers, as_path
from robot_perception.extras import needing

if TYPE_CHECKING:
    from robot_perception.cameras import StereoRig

ROUNDING = 1e-5
"""Share of a focal length by which the matrices of one pair may differ: files are rounded."""
ASIDE = 0.01
"""Share of the baseline by which the right camera may lie beside the row of the left one."""
NUMBERED = re.compile(r"(?:P(?:_?rect)?|cam(?:era)?)_?0*(\d{1,2})", re.IGNORECASE)
SIDED = re.compile(r"(left)|(right)", re.IGNORECASE)
FORMS = {  # of YAML and XML, by a key that tells it
    "projection_matrix": "camera_info of ROS",
    "camera_name": "camera_info of ROS",
    "T_BS": "sensor.yaml of EuRoC",
    "Camera.fx": "settings of ORB-SLAM",
}
WANTED = (
    "wanted are the projection matrices, 3 × 4, of two cameras whose pictures are rectified: P0 and"
    " P1 as KITTI has them, P1 and P2 of OpenCV's stereoRectify, or projection_matrix in left.yaml"
    " and right.yaml of ROS"
)
NO_YAML = "no YAML, or a damaged one"

Matrix = Float[np.ndarray, "3 4"]


@dataclass(frozen=True, eq=False, slots=True)
class Calibration:
    """A rectified stereo camera.

    Parameters
    ----------
    focal
        Focal lengths (fx, fy), px.
    centre
        Principal point (cx, cy), px.
    baseline
        Distance of the right camera from the left, m.
    report
        How its file was read, if it comes from one.
    """

    focal: tuple[float, float]
    centre: tuple[float, float]
    baseline: float
    report: ReadReport | None = None

    def rig(self, size: tuple[int, int]) -> "StereoRig":
        """Return the cameras.

        Parameters
        ----------
        size
            Width and height of the pictures, px.

        Raises
        ------
        ValueError
            If the size is not two positive whole numbers.
        """
        from robot_perception.cameras import Pinhole, StereoRig  # which need OpenCV

        return StereoRig(Pinhole(self.focal, self.centre, size), self.baseline)


class _Projections(NamedTuple):
    """The projection matrices of a file, by its names for them, or by their lines."""

    path: Path
    form: str
    matrices: dict[str, Matrix]
    single: bool = False  # whether the file is of one camera by its form


def read_calibration(
    path: str | Path,
    right: str | Path | None = None,
    *,
    cameras: tuple[int, int] | None = None,
) -> Calibration:
    """Read the projection matrices of a rectified pair of cameras.

    They are taken by their names: ``P0:`` to ``P3:`` of KITTI's ``calib.txt`` and ``P_rect_00:`` to
    ``P_rect_03:`` of its ``calib_cam_to_cam.txt``; ``P1`` and ``P2`` of OpenCV's YAML or XML;
    ``projection_matrix`` in two files of ROS's ``camera_info``; ``cam0`` and ``cam1`` of Kalibr's
    camchain, if these are of rectified pictures. In a text without such names the first two lines
    are those of the left and the right camera, and the report says so.

    Parameters
    ----------
    path
        The file.
    right
        That of the right camera, if each has its own; without it ``right.yaml`` is looked for
        beside ``left.yaml``.
    cameras
        Which of several cameras are left and right, such as (2, 3) for P2 and P3.

    Raises
    ------
    CorruptLog
        If a file is empty or damaged, has no projection matrices of two cameras or not those that
        are wanted, or they are not those of a rectified pair.
    FileNotFoundError
        If there is no such file.
    """
    return read_pair(path, right, cameras=cameras)[0]


def read_pair(
    path: str | Path,
    right: str | Path | None = None,
    *,
    cameras: tuple[int, int] | None = None,
) -> tuple[Calibration, Float[np.ndarray, " 3"]]:
    """Read a calibration as `read_calibration` does, and where its left camera is.

    Returns
    -------
    Calibration
        Of the pair.
    (3,)
        Place of the left camera in the frame from which the file counts, m.
    """
    path, right = as_path(path), None if right is None else as_path(right, "right")
    if cameras is not None:
        cameras = tuple(checks.integers("cameras", cameras, (2,), 0).tolist())
    found = _projections(path)
    if found.single:
        found = _joined(found, right)
    elif right is not None:
        raise CorruptLog(f"{path}: {found.form}, and not of one camera: no right one, {right}")
    names, remarks = _chosen(found, cameras)
    left, other = (found.matrices[name] for name in names)
    if fault := unrectified(left, other):
        two = " and ".join(names)
        raise CorruptLog(f"{path}: the matrices are not those of a rectified pair: {two} {fault}")
    report = ReadReport(path, {"projection": len(found.matrices)}, {}, "matrices", remarks)
    return _calibration(left, other, report), _places(left, other)[0]


def rectified_pair(left: Matrix, right: Matrix) -> Calibration | None:
    """Return what two projection matrices tell, or nothing if they are of no rectified pair."""
    return None if unrectified(left, right) else _calibration(left, right)


def unrectified(left: Matrix, right: Matrix) -> str:
    """Return why two projection matrices are not those of a rectified pair; nothing if they are.

    Those of one pair may differ as rounded numbers do, and the right camera may lie beside the row
    of the left one by a hundredth of the baseline, as of KITTI's colour cameras.
    """
    focal = min(left[0, 0], left[1, 1], right[0, 0], right[1, 1])
    if not focal > 0:
        return f"have a focal length of {focal:g} px, as of a camera that is not calibrated"
    skew = max(np.abs(one[[0, 1], [1, 0]]).max() for one in (left, right))
    if not skew <= ROUNDING * focal:
        return f"have a skew of {skew:g} px"
    if any(np.abs(one[2, :3] - [0, 0, 1]).max() > ROUNDING for one in (left, right)):
        return "have a last row that does not begin with 0 0 1"
    apart = np.abs(left[:, :3] - right[:, :3]).max()
    if not apart <= ROUNDING * focal:
        return f"differ by {apart:g} px in their first three columns"
    baseline, *off = np.subtract(*_places(left, right)[::-1]).tolist()
    if baseline < 0:
        return f"are swapped: the right camera lies {-baseline:g} m left of the left one"
    if not np.hypot(*off) <= ASIDE * baseline:
        return f"are not side by side: the right camera is off by {np.hypot(*off):g} m"
    return "" if baseline else "have no baseline: both are of one place"


def _calibration(left: Matrix, right: Matrix, report: ReadReport | None = None) -> Calibration:
    """Return the calibration of a rectified pair."""
    (fx, _, cx, _), (_, fy, cy, _), _ = left.tolist()
    mine, other = _places(left, right)
    return Calibration((fx, fy), (cx, cy), float(other[0] - mine[0]), report)


def _places(left: Matrix, right: Matrix) -> Float[np.ndarray, "2 3"]:
    """Return where two cameras of one focal length and centre are, m."""
    (fx, _, cx, _), (_, fy, cy, _), _ = left.tolist()
    u, v, depth = np.stack([left[:, 3], right[:, 3]], axis=1)
    return 0.0 - np.stack([(u - cx * depth) / fx, (v - cy * depth) / fy, depth], axis=1)


def _chosen(
    found: _Projections, cameras: tuple[int, int] | None
) -> tuple[tuple[str, str], tuple[str, ...]]:
    """Return the names of the left and the right matrix, and a sentence if that was a choice."""
    numbers = {_number(name): name for name in found.matrices}
    if cameras and {*cameras} <= numbers.keys():
        return (numbers[cameras[0]], numbers[cameras[1]]), ()
    names = [numbers[k] for k in sorted(numbers.keys() - {None})]
    taken = names or list(found.matrices)
    if len(taken) < 2:
        told = f" ({taken[0]})" if taken else ""
        raise CorruptLog(
            f"{found.path}: there must be two projection matrices, got {len(taken)}{told}; it is"
            f" {found.form}; {WANTED}"
        )
    if cameras and len(names) > 2:
        two = f"{cameras[0]} and {cameras[1]}"
        raise CorruptLog(
            f"{found.path}: no matrices of cameras {two}; there are {', '.join(names)}"
        )
    if cameras is None and len(names) == 2:
        return (names[0], names[1]), ()
    why = "there are no others" if names else "there are no names such as P0 and P1"
    why = f"there are also {', '.join(names[2:])}" if names[2:] else why
    sides = f"{taken[0]} is taken for the left camera, {taken[1]} for the right one"
    return (taken[0], taken[1]), (f"{found.path.name}: {sides}; {why}",)


def _number(name: str) -> int | None:
    """Return which camera a name says, 0 for left and 1 for right; nothing if it does not say."""
    if told := NUMBERED.fullmatch(name):
        return int(told[1])
    sides = {bool(match[2]) for match in SIDED.finditer(Path(name).name)}
    return int(sides.pop()) if len(sides) == 1 else None


def _joined(found: _Projections, right: Path | None) -> _Projections:
    """Return the matrices of two files of one camera each."""
    path = found.path
    if right is None:
        beside = path.with_name(re.sub("left", "right", path.name))
        if beside == path or not beside.exists():
            raise CorruptLog(f"{path}: {found.form}, of one camera; {WANTED}")
        right = beside
    other = _projections(right)
    if not other.single:
        raise CorruptLog(f"{right}: {other.form}, and not of one right camera as beside {path}")
    eyes = {str(one.path): matrix for one in (found, other) for matrix in one.matrices.values()}
    return found._replace(matrices=eyes)


def _projections(path: Path) -> _Projections:
    """Return the projection matrices of a file of any form."""
    lines = Lines(path)
    path, text = lines.path, lines.text()
    if text.lstrip().startswith("<"):
        return _of_document(path, "XML of OpenCV", _xml(path, text))
    ending = Path(path.name.removesuffix(".gz")).suffix.lower()
    if text.startswith(("%YAML", "---", "{")) or ending in (".yaml", ".yml", ".json"):
        kind = "YAML of OpenCV" if text.startswith("%YAML:") else "YAML"
        return _of_document(path, kind, _yaml(lines, text))
    return _of_text(Lines(path))


def _of_text(lines: Lines) -> _Projections:
    """Return the matrices of lines with or without names."""
    named: dict[str, Matrix] = {}
    bare: dict[str, Matrix] = {}
    for words in lines.rows():
        if words[0].startswith(b"["):
            raise lines.error(f"a section in brackets, as camera_info of ROS (oST) has; {WANTED}")
        label, _, rest = words[0].partition(b":")
        if not words[0] or _is_number(words[0]):
            if len(bare) < 2:
                bare[f"line {lines.number}"] = _matrix(lines, words)
            continue
        words = [word for word in (rest.strip(), *words[1:]) if word not in (b"", b":", b"=")]
        name, matrices = label.decode(), named if _number(label.decode()) is not None else bare
        if name in matrices:
            raise lines.error(f"names {name} a second time")
        fits = len(bare) < 2 and len(words) == 12 and all(map(_is_number, words))
        if matrices is named or fits:
            matrices[name] = _matrix(lines, words)
    return _Projections(lines.path, "text", named or bare)


def _is_number(word: bytes) -> bool:
    return are_numbers([word.replace(b",", b".")])  # between some marks commas are decimal


def _matrix(lines: Lines, words: list[bytes]) -> Matrix:
    """Return the matrix that a line holds by rows."""
    lines.expect(words, 12)
    return lines.numbers(lines.points(words)).reshape(3, 4)


def _of_document(path: Path, kind: str, document: Any) -> _Projections:
    """Return the matrices of YAML or XML as OpenCV, ROS or Kalibr write it."""
    if not isinstance(document, Mapping):
        raise CorruptLog(f"{path}: {kind} without names; {WANTED}")
    parts = {str(name): part for name, part in document.items()}
    forms = [form for key, form in FORMS.items() if key in parts]
    form = f"YAML, {forms[0]}" if forms else f"{kind} with {first(parts) or 'nothing'}"
    if "projection_matrix" in parts:
        own = {path.name: _numbers(path, "projection_matrix", parts["projection_matrix"], (3, 4))}
        return _Projections(path, form, own, single=True)
    chain = {name: part for name, part in parts.items() if _has(part, "intrinsics")}
    if chain:
        return _Projections(path, "YAML, camchain of Kalibr", _of_chain(path, chain))
    found = {}
    for name, part in parts.items():
        part = part["projection_matrix"] if _has(part, "projection_matrix") else part
        if _has(part, "data") and (part.get("rows"), part.get("cols")) == (3, 4):
            found[name] = _numbers(path, name, part, (3, 4))
    if len(found) < 2:
        raise CorruptLog(f"{path}: {form}; {WANTED}")
    return _Projections(path, form, found)


def _of_chain(path: Path, chain: dict[str, Any]) -> dict[str, Matrix]:
    """Return the projection matrices of cameras as Kalibr has them, if they are rectified."""
    found, T = {}, np.eye(4)
    for name, part in chain.items():
        model, bent = part.get("camera_model", "pinhole"), part.get("distortion_coeffs") or [0]
        if found:
            T = _numbers(path, f"T_cn_cnm1 of {name}", part.get("T_cn_cnm1"), (4, 4)) @ T
        turned = np.abs(T[:3, :3] - np.eye(3)).max() > ROUNDING
        if model != "pinhole" or np.any(bent) or turned:
            what = f"turned against {next(iter(chain))}" if turned else f"{model} with distortion"
            raise CorruptLog(
                f"{path}: YAML, camchain of Kalibr, whose {name} is {what}, not rectified; {WANTED}"
            )
        fx, fy, cx, cy = _numbers(path, f"intrinsics of {name}", part["intrinsics"], (4,))
        found[name] = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]]) @ T[:3]
    return found


def _has(part: Any, name: str) -> bool:
    return isinstance(part, Mapping) and name in part


def _numbers(path: Path, name: str, part: Any, shape: tuple[int, ...]) -> np.ndarray:
    """Return the numbers of an entry: in a list, in lists, or in one that is called data."""
    part = part["data"] if _has(part, "data") else part
    try:
        values = np.array(part.split() if isinstance(part, str) else part, dtype=float)
    except (TypeError, ValueError):
        raise CorruptLog(f"{path}: a value of {name} is not a number") from None
    if values.size != np.prod(shape) or not np.isfinite(values).all():
        raise CorruptLog(f"{path}: {name} must be {np.prod(shape)} finite numbers")
    return values.reshape(shape)


def _yaml(lines: Lines, text: str) -> Any:
    """Return what YAML holds, that of OpenCV too, which is not quite YAML."""
    with needing():
        import yaml

    class Loader(yaml.SafeLoader):
        """Takes a matrix of OpenCV for a mapping."""

    Loader.add_multi_constructor(
        "tag:yaml.org,2002:opencv-", lambda loader, _, node: loader.construct_mapping(node, True)
    )
    try:
        return yaml.load(re.sub(r"\A%YAML:.*", "", text), Loader)
    except yaml.MarkedYAMLError as error:
        raise lines.error(f"{NO_YAML} ({error.problem})", error.problem_mark.line + 1) from error
    except (yaml.YAMLError, RecursionError, ValueError) as error:
        raise CorruptLog(f"{lines.path}: {NO_YAML} ({error})") from error


def _xml(path: Path, text: str) -> dict[str, Any]:
    """Return the matrices of OpenCV's XML as those of its YAML."""
    try:
        return {part.tag: _entries(part) for part in ElementTree.fromstring(text)}
    except (ElementTree.ParseError, ValueError) as error:
        raise CorruptLog(f"{path}: no XML, or a damaged one ({error})") from error


def _entries(part: ElementTree.Element) -> dict[str, Any]:
    """Return the texts in an entry of XML, whole numbers as such."""
    texts = {one.tag: (one.text or "").strip() for one in part}
    return {name: int(text) if text.isdecimal() else text for name, text in texts.items()}
