"""A camera that looks straight up through a fisheye lens and sees all round a robot.

The lens is equidistant: a ray at an angle θ off the optical axis meets the image r = f·θ from the
centre. Ahead of the robot is down in the image and left of it is left, so the direction φ of a
pixel (u, v), counter-clockwise from ahead, is that of (v - v₀, u₀ - u).

What stands still is made of upright faces and boxes, so one cast in the plan for each direction
finds what the pixels of a radius can meet; bodies are ellipsoids, met in closed form. Colours are
shares of the light that comes back (blue, green, red, linear); only the last step makes grey values
of 8 bits.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from data_synth._checks import array, generator, instance, number, reals, whole, wholes
from data_synth._kernels import kernel

_FINE = 2  # rays along each side of a pixel
_DIRECTIONS = 4096  # of the cast in the plan; a pixel at the rim is four wide
_DEEP = 24  # boxes met in a direction, at most
_PANEL, _LAMP, _JOINT = 0.72, 4.0, 0.5  # how bright the parts of the ceiling are in their light
_RIM_LEFT = 0.65  # of the light at the rim
_GAMMA = 1 / 2.2
_BRIGHTEST = 1e30  # light, shares of full light: no pixel of 32 bits overflows
_LIGHTS, _OWNERS = 255, 2**15 - 1  # the last of each: so are they counted, ray by ray
_CLOSE = 0.02  # a body does not come nearer to the lens, m


@dataclass(frozen=True, slots=True)
class Fisheye:
    """A camera on top of a robot that looks up; all values are ours.

    Parameters
    ----------
    size
        Width and height of the image, pixels.
    focal_px
        Pixels for each radian off the optical axis.
    height
        Above the floor, m: below the faces of people who stand.
    widest
        Largest angle off the axis that the lens lets in, rad.
    read_noise
        Deviation of the noise in the dark, shares of full light.
    photon_noise
        Variance of the noise for a share of full light.
    """

    size: int = 320
    focal_px: float = 90.0
    height: float = 1.2
    widest: float = float(np.deg2rad(100.0))
    read_noise: float = 0.004
    photon_noise: float = 0.0004

    def __post_init__(self) -> None:
        whole("size", self.size, 8, 1024)
        number("focal_px", self.focal_px, 1.0, 1e5)
        number("height", self.height, 0.1, 2.5)
        number("widest", self.widest, 0.1, 3.0)
        number("read_noise", self.read_noise, 0.0, 1.0)
        number("photon_noise", self.photon_noise, 0.0, 1.0)

    @property
    def centre_px(self) -> tuple[float, float]:
        """Point at which the optical axis meets the image, pixels."""
        return (self.size - 1) / 2, (self.size - 1) / 2

    def project(self, points: np.ndarray) -> np.ndarray:
        """Return the pixels of points, also of points that the lens does not let in.

        Parameters
        ----------
        points : (n, 3)
            Ahead of the robot, to its left and above the floor, m.

        Returns
        -------
        (n, 2)
            Column and row, pixels.

        Raises
        ------
        ValueError
            If a point is where the lens is.
        """
        ahead, left, up = array("points", points, (None, 3)).T
        away = np.hypot(ahead, left)
        if ((away == 0) & (up == self.height)).any():
            raise ValueError(f"points must not lie in the lens at {self.height:g} m")
        radius = self.focal_px * np.arctan2(away, up - self.height)
        bearing = np.arctan2(left, ahead)
        u, v = self.centre_px
        return np.stack([u - radius * np.sin(bearing), v + radius * np.cos(bearing)], axis=-1)

    def bearing(self, pixels: np.ndarray) -> np.ndarray:
        """Return directions of pixels (n, 2), column and row: rad, counter-clockwise from ahead."""
        columns, rows = array("pixels", pixels, (None, 2)).T
        u, v = self.centre_px
        return np.arctan2(u - columns, rows - v)

    def elevation(self, pixels: np.ndarray) -> np.ndarray:
        """Return how far above the horizon pixels (n, 2), column and row, look, rad."""
        columns, rows = array("pixels", pixels, (None, 2)).T
        u, v = self.centre_px
        return np.pi / 2 - np.hypot(columns - u, rows - v) / self.focal_px


@dataclass(frozen=True, eq=False, slots=True)
class Stage:
    """Static scene: upright faces, boxes, a floor and a ceiling.

    Parameters
    ----------
    walls : (w, 2, 2)
        Ends of the faces, from the floor to the ceiling, free space to the left, m.
    wall_paint : (w, 3)
        Their colours.
    wall_light : (w,)
        Which light falls on them.
    hung : (h, 4)
        What hangs on the faces: from and to along the face, lower and upper edge, m.
    hung_first : (w + 1,)
        Where the hangings of each face begin.
    hung_picture, hung_light : (h,)
        Which picture they show, and in which light.
    boxes : (b, 4, 2)
        Corners of the boxes in the plan, counter-clockwise, m.
    spans : (b, 2)
        Their lower and upper ends, m.
    box_paint : (b, 3)
        Their colours.
    box_picture, box_light : (b,)
        The picture on their sides, -1 for none, and the light.
    pictures : (p, n, n, 3)
        Colours, the upper left corner first.
    plan : (rows, columns)
        The light of each cell of the floor.
    ceiling : (rows, columns)
        What is above it: 0 for a panel, 1 for a lamp, 2 for a joint between panels.
    corner : (2,)
        Of both rasters, m.
    cell
        Side of a cell, m.
    high
        Of the ceiling, m.
    """

    walls: np.ndarray
    wall_paint: np.ndarray
    wall_light: np.ndarray
    hung: np.ndarray
    hung_first: np.ndarray
    hung_picture: np.ndarray
    hung_light: np.ndarray
    boxes: np.ndarray
    spans: np.ndarray
    box_paint: np.ndarray
    box_picture: np.ndarray
    box_light: np.ndarray
    pictures: np.ndarray
    plan: np.ndarray
    ceiling: np.ndarray
    corner: np.ndarray
    cell: float
    high: float

    def __post_init__(self) -> None:
        pictures = len(array("pictures", self.pictures, (None, None, None, 3))) - 1
        if not self.pictures.shape[1] == self.pictures.shape[2] > 0:
            raise ValueError(f"pictures must be square, got {self.pictures.shape}")
        walls = len(array("walls", self.walls, (None, 2, 2)))
        hung = len(array("hung", self.hung, (None, 4)))
        boxes = len(array("boxes", self.boxes, (None, 4, 2)))
        array("wall_paint", self.wall_paint, (walls, 3))
        array("spans", self.spans, (boxes, 2))
        array("box_paint", self.box_paint, (boxes, 3))
        array("corner", self.corner, (2,))
        for name, count in (("wall_light", walls), ("hung_light", hung), ("box_light", boxes)):
            wholes(name, getattr(self, name), (count,), 0, _LIGHTS)
        wholes("hung_first", self.hung_first, (walls + 1,), 0, hung)
        wholes("hung_picture", self.hung_picture, (hung,), 0, pictures)
        wholes("box_picture", self.box_picture, (boxes,), -1, pictures)
        plan = wholes("plan", self.plan, (None, None), 0, _LIGHTS)
        wholes("ceiling", self.ceiling, plan.shape, 0, 2)
        if not plan.size:
            raise ValueError(f"plan must have a cell at least, got {plan.shape}")
        number("cell", self.cell, above=0.0)
        number("high", self.high, above=0.0)

    def light_at(self, places: np.ndarray) -> np.ndarray:
        """Return which light falls on places (n, 2), beside the floor that of the nearest cell."""
        columns, rows = np.floor((array("places", places, (None, 2)) - self.corner) / self.cell).T
        rows = rows.clip(0, self.plan.shape[0] - 1).astype(int)
        return self.plan[rows, columns.clip(0, self.plan.shape[1] - 1).astype(int)].astype(int)


@dataclass(frozen=True, eq=False, slots=True)
class Bodies:
    """Ellipsoids |S (x - c)| = 1 with colours.

    Parameters
    ----------
    centres : (e, 3)
        In the world, m.
    shapes : (e, 3, 3)
        The maps S to the unit sphere, 1/m; of a head the rows are ahead, left and up.
    paint : (e, 3)
        Colours; of a head that of its skin.
    hair : (e, 3)
        Of a head the colour of the hair.
    heads : (e,)
        0 for a plain ellipsoid, 1 for a head with short hair, 2 with long hair.
    owners : (e,)
        Whose it is.
    light : (e,)
        Which light falls on it.
    """

    centres: np.ndarray
    shapes: np.ndarray
    paint: np.ndarray
    hair: np.ndarray
    heads: np.ndarray
    owners: np.ndarray
    light: np.ndarray

    def __post_init__(self) -> None:
        count = len(array("centres", self.centres, (None, 3)))
        array("shapes", self.shapes, (count, 3, 3))
        array("paint", self.paint, (count, 3))
        array("hair", self.hair, (count, 3))
        wholes("heads", self.heads, (count,), 0, 2)
        wholes("owners", self.owners, (count,), 0, _OWNERS)
        wholes("light", self.light, (count,), 0, _LIGHTS)


@dataclass(frozen=True, eq=False, slots=True)
class View:
    """Light that comes through the lens, before noise.

    Parameters
    ----------
    light : (size, size, 3)
        Blue, green and red, shares of full light.
    faces : (n,)
        Pixels of the skin of each owner's head, parts counted.
    """

    light: np.ndarray
    faces: np.ndarray


def linear(colour: np.ndarray) -> np.ndarray:
    """Return red, green and blue of 8 bits (…, 3) as shares of full light: blue, green and red."""
    colour = reals("colour", colour)
    if colour.shape[-1:] != (3,) or not ((colour >= 0) & (colour <= 255)).all():
        raise ValueError(f"colour must be (…, 3) from 0 to 255, got {colour.shape}")
    return (colour[..., ::-1] / 255) ** (1 / _GAMMA)


def view(
    camera: Fisheye, stage: Stage, pose: np.ndarray, bodies: Bodies, light: np.ndarray
) -> View:
    """Return what comes through the lens.

    Parameters
    ----------
    camera, stage, bodies
        What looks, what stands still, and who is there.
    pose : (3,)
        Of the robot: x, y, heading, m and rad.
    light : (n, 3)
        Strengths of the lights.
    """
    instance("camera", camera, Fisheye)
    instance("stage", stage, Stage)
    instance("bodies", bodies, Bodies)
    x, y, heading = array("pose", pose, (3,))
    light = array("light", light, (None, 3)).astype(np.float32)
    used = (stage.wall_light, stage.hung_light, stage.box_light, stage.plan, bodies.light)
    last = max(int(part.max(initial=0)) for part in used)
    if len(light) <= last:
        raise ValueError(f"light must be one for each of {last + 1}, got {len(light)}")
    colours, depths, lit = (part.copy() for part in _behind(camera, stage, x, y, heading))
    whose = np.full(depths.shape, -1, dtype=np.int16)
    rays, _ = _rays(camera)
    _bodies(
        *(np.array([x, y, camera.height]), _turned(heading), rays, camera.focal_px * _FINE),
        *(bodies.centres, bodies.shapes, bodies.paint, bodies.hair, bodies.heads),
        *(bodies.owners, bodies.light, colours, depths, lit, whose),
    )
    seen = np.bincount(whose[whose >= 0], minlength=int(bodies.owners.max(initial=-1)) + 1)
    return View(_gathered(colours, lit, light, _FINE), seen / _FINE**2)


def expose(
    camera: Fisheye, light: np.ndarray, gain: float, *, rng: np.random.Generator
) -> np.ndarray:
    """Return the image (size, size, 3) that the camera makes of light: blue, green, red, 8 bits.

    Parameters
    ----------
    camera
        The camera.
    light : (size, size, 3)
        What comes through the lens.
    gain
        Of the exposure.
    rng
        Source of the noise.
    """
    instance("camera", camera, Fisheye)
    light = array("light", light, (camera.size, camera.size, 3), _BRIGHTEST).astype(np.float32)
    number("gain", gain, 0.0, 1e6)
    noise = generator(rng).standard_normal(light.shape, dtype=np.float32)
    fall = _fall_off(camera)
    table = np.rint(255 * np.linspace(0.0, 1.0, 4096) ** _GAMMA).astype(np.uint8)
    image = np.empty(light.shape, dtype=np.uint8)
    _develop(light, fall, gain, camera.read_noise, camera.photon_noise, noise, table, image)
    return image


def _turned(heading: float) -> np.ndarray:
    cos, sin = np.cos(heading), np.sin(heading)
    return np.array([[cos, -sin], [sin, cos]])


@lru_cache(maxsize=1)  # the same for image after image of a robot that stands
def _behind(
    camera: Fisheye, stage: Stage, x: float, y: float, heading: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Colours and depths of what stands still for each fine ray, and which light falls on it."""
    size = camera.size * _FINE
    colours = np.zeros((size, size, 3), dtype=np.float32)
    depths = np.full((size, size), np.inf, dtype=np.float32)
    lit = np.zeros((size, size), dtype=np.uint8)
    _background(
        *(np.array([x, y, camera.height]), _turned(heading), *_rays(camera)),
        *_around(x, y, heading, stage.walls, stage.boxes, _DIRECTIONS, _DEEP),
        *(stage.walls, stage.wall_paint, stage.wall_light),
        *(stage.hung, stage.hung_first, stage.hung_picture, stage.hung_light),
        *(stage.boxes, stage.spans, stage.box_paint, stage.box_picture, stage.box_light),
        *(
            stage.pictures,
            stage.plan,
            stage.ceiling,
            stage.corner,
            stage.cell,
            stage.high,
            colours,
            depths,
            lit,
        ),
    )
    return colours, depths, lit


@lru_cache(maxsize=2)
def _rays(camera: Fisheye) -> tuple[np.ndarray, np.ndarray]:
    """Directions of the fine rays (ahead and left of the unit length in the plan, cosine and sine
    of the elevation), and the number of the direction in the plan, -1 beside the lens.
    """
    fine = (np.arange(camera.size * _FINE) + 0.5) / _FINE - 0.5
    columns, rows = np.meshgrid(fine, fine)
    u, v = camera.centre_px
    left, ahead = u - columns, rows - v
    away = np.maximum(np.hypot(left, ahead), 1e-9)
    off = away / camera.focal_px
    rays = np.stack([ahead / away, left / away, np.sin(off), np.cos(off)], axis=-1)
    turn = np.arctan2(left, ahead) % (2 * np.pi)
    direction = np.floor(turn / (2 * np.pi) * _DIRECTIONS).astype(np.int16) % _DIRECTIONS
    return rays.astype(np.float32), np.where(off <= camera.widest, direction, -1).astype(np.int16)


@lru_cache(maxsize=2)
def _fall_off(camera: Fisheye) -> np.ndarray:
    """Share of the light that the lens lets through, pixel by pixel: none beside its image."""
    u, v = camera.centre_px
    rows, columns = np.ogrid[: camera.size, : camera.size]
    off = np.hypot(columns - u, rows - v) / camera.focal_px / camera.widest
    edge = np.clip((1 - off) * camera.widest * camera.focal_px / 1.5, 0, 1)  # 1.5 pixels wide
    return ((1 - (1 - _RIM_LEFT) * off**2) * edge).astype(np.float32)


@kernel()
def _around(x, y, heading, walls, boxes, directions, deep):
    """Return for each direction of the plan the distance and index of the first wall, and how many
    boxes are met before it: near and far ends, indices and the edge that is met, near first.
    """
    step = 2 * np.pi / directions
    wall, face = np.full(directions, np.inf), np.full(directions, -1, dtype=np.int32)
    cos = np.cos(heading + (np.arange(directions) + 0.5) * step)
    sin = np.sin(heading + (np.arange(directions) + 0.5) * step)
    for k in range(len(walls)):
        px, py = walls[k, 0, 0] - x, walls[k, 0, 1] - y
        qx, qy = walls[k, 1, 0] - x, walls[k, 1, 1] - y
        area = px * qy - py * qx
        if area <= 0:  # seen from behind, or from its edge
            continue
        low = np.arctan2(py, px) - heading
        high = low + np.arctan2(area, px * qx + py * qy)
        begin, end = np.ceil(low / step - 0.5), np.floor(high / step - 0.5)
        if not begin <= end:  # or NaN, which a loop would not end at
            continue
        for i in range(int(begin), int(end) + 1):
            j = i % directions
            away = area / (cos[j] * (qy - py) - sin[j] * (qx - px))
            if 0 < away < wall[j]:
                wall[j], face[j] = away, k
    count = np.zeros(directions, dtype=np.int32)
    near, far = np.empty((directions, deep)), np.empty((directions, deep))
    met = np.empty((directions, deep), dtype=np.int32)
    edge = np.empty((directions, deep), dtype=np.int8)
    for b in range(len(boxes)):
        mx, my = boxes[b, :, 0].mean() - x, boxes[b, :, 1].mean() - y
        middle = np.arctan2(my, mx)
        low, high, inside = 0.0, 0.0, True
        for c in range(4):
            px, py = boxes[b, c, 0] - x, boxes[b, c, 1] - y
            qx, qy = boxes[b, (c + 1) % 4, 0] - x, boxes[b, (c + 1) % 4, 1] - y
            inside = inside and px * qy - py * qx > 0
            off = np.arctan2(py * mx - px * my, px * mx + py * my)
            low, high = min(low, off), max(high, off)
        begin = np.ceil((middle + low - heading) / step - 0.5)
        end = np.floor((middle + high - heading) / step - 0.5)
        if inside:
            begin, end = 0.0, directions - 1.0
        if not begin <= end:
            continue
        for i in range(int(begin), int(end) + 1):
            j = i % directions
            enter, leave, side = 0.0, np.inf, 0
            for c in range(4):
                px, py = boxes[b, c, 0] - x, boxes[b, c, 1] - y
                ex, ey = boxes[b, (c + 1) % 4, 0] - x - px, boxes[b, (c + 1) % 4, 1] - y - py
                slope = ey * cos[j] - ex * sin[j]  # along the outward normal
                if slope == 0:
                    continue
                away = (ey * px - ex * py) / slope
                if slope < 0 and away > enter:
                    enter, side = away, c
                elif slope > 0:
                    leave = min(leave, away)
            if enter >= leave or enter >= wall[j] or count[j] == deep:
                continue
            k = count[j]
            while k > 0 and near[j, k - 1] > enter:
                near[j, k], far[j, k] = near[j, k - 1], far[j, k - 1]
                met[j, k], edge[j, k] = met[j, k - 1], edge[j, k - 1]
                k -= 1
            near[j, k], far[j, k], met[j, k], edge[j, k] = enter, leave, b, side
            count[j] += 1
    return wall, face, count, near, far, met, edge


@kernel()
def _background(
    eye, turned, rays, direction, wall, face, count, near, far, met, edge, walls, wall_paint,
    wall_light, hung, hung_first, hung_picture, hung_light, boxes, spans, box_paint, box_picture,
    box_light, pictures, plan, ceiling, corner, cell, high, colours, depths, lit,
):  # fmt: skip
    """Write the colour and the depth of what stands still for each ray."""
    x, y, h = eye
    size = colours.shape[0]
    paint = np.empty(3)
    for row in range(size):
        for column in range(size):
            j = direction[row, column]
            if j < 0:
                continue
            ahead, left = rays[row, column, 0], rays[row, column, 1]
            level, rise = rays[row, column, 2], rays[row, column, 3]
            east = turned[0, 0] * ahead + turned[0, 1] * left
            north = turned[1, 0] * ahead + turned[1, 1] * left
            slope = rise / level
            first = wall[j]
            along = 0.0
            f = face[j]
            if f >= 0:
                px, py = walls[f, 0, 0] - x, walls[f, 0, 1] - y
                ex, ey = walls[f, 1, 0] - walls[f, 0, 0], walls[f, 1, 1] - walls[f, 0, 1]
                area = east * ey - north * ex
                if area > 0:
                    first = (px * ey - py * ex) / area
                    long = np.sqrt(ex * ex + ey * ey)
                    along = min(max((px * north - py * east) / area, 0.0), 1.0) * long
            up = h + first * slope
            kind = 0  # a wall; else 1 the ceiling, 2 the floor, 3 a side, 4 a top, 5 an underside
            if up > high:
                kind, first = 1, (high - h) / slope
            elif up < 0:
                kind, first = 2, -h / slope
            b, c = -1, 0
            for k in range(count[j]):
                enter = near[j, k]
                if enter >= first:
                    break
                this, side = met[j, k], edge[j, k]
                if enter > 0:
                    px, py = boxes[this, side, 0] - x, boxes[this, side, 1] - y
                    ex = boxes[this, (side + 1) % 4, 0] - x - px
                    ey = boxes[this, (side + 1) % 4, 1] - y - py
                    area = ey * east - ex * north
                    if area < 0:
                        enter = (ey * px - ex * py) / area
                leave = max(far[j, k], enter)
                low, top = spans[this, 0], spans[this, 1]
                begin, end = h + enter * slope, h + leave * slope
                if low <= begin <= top:
                    found, what = enter, 3
                elif begin > top and end < top:
                    found, what = (top - h) / slope, 4
                elif begin < low and end > low:
                    found, what = (low - h) / slope, 5
                else:
                    continue
                if found < first:
                    first, kind, b, c = found, what, this, side
            up = h + first * slope
            depths[row, column] = first / level
            which, shade = 0, 1.0
            if kind == 0 and f >= 0:
                which = wall_light[f]
                paint[:] = wall_paint[f]
                if up < 0.08:  # skirting board
                    paint *= 0.45
                for k in range(hung_first[f], hung_first[f + 1]):
                    if hung[k, 0] <= along <= hung[k, 1] and hung[k, 2] <= up <= hung[k, 3]:
                        which = hung_light[k]
                        across = (along - hung[k, 0]) / (hung[k, 1] - hung[k, 0])
                        down = (hung[k, 3] - up) / (hung[k, 3] - hung[k, 2])
                        _look_up(pictures, hung_picture[k], 1.0 - across, down, paint)
                        break
                ends = min(along, long - along)
                shade = (0.6 + 0.4 * up / high) * (1.0 - 0.3 * np.exp(-ends / 0.2))
                shade *= 0.93 + 0.07 * (walls[f, 1, 0] - walls[f, 0, 0]) / long
            elif kind >= 3:
                which = box_light[b]
                paint[:] = box_paint[b]
                shade = 1.0 if kind == 4 else (0.4 if kind == 5 else 0.55 + 0.3 * up / high)
                if kind == 3:
                    px, py = boxes[b, c, 0], boxes[b, c, 1]
                    ex, ey = boxes[b, (c + 1) % 4, 0] - px, boxes[b, (c + 1) % 4, 1] - py
                    shade *= 0.9 + 0.1 * ex / np.sqrt(ex * ex + ey * ey)
                    if box_picture[b] >= 0:
                        across = (x + first * east - px) * ex + (y + first * north - py) * ey
                        across = min(max(across / (ex * ex + ey * ey), 0.0), 1.0)
                        down = (spans[b, 1] - up) / (spans[b, 1] - spans[b, 0])
                        _look_up(pictures, box_picture[b], across, down, paint)
            else:
                i = int(min(plan.shape[0] - 1.0, max(0.0, (y + first * north - corner[1]) / cell)))
                k = int(min(plan.shape[1] - 1.0, max(0.0, (x + first * east - corner[0]) / cell)))
                which = plan[i, k]
                if kind == 2:
                    paint[:] = 0.22
                else:
                    paint[:] = (_PANEL, _LAMP, _JOINT)[ceiling[i, k]]
            lit[row, column] = which
            for channel in range(3):
                colours[row, column, channel] = paint[channel] * shade


@kernel()
def _look_up(pictures, which, across, down, paint):
    """Write the texel of a picture."""
    n = pictures.shape[1]
    i, j = int(min(n - 1.0, max(0.0, down * n))), int(min(n - 1.0, max(0.0, across * n)))
    for channel in range(3):
        paint[channel] = pictures[which, i, j, channel]


@kernel()
def _bodies(
    eye, turned, rays, reach, centres, shapes, paint, hair, heads, owners, lights, colours, depths,
    lit, whose,
):  # fmt: skip
    """Write the colour, the depth and the owner of each ray that meets an ellipsoid first."""
    size = colours.shape[0]
    middle = (size - 1) / 2
    skin = np.empty(3)
    for e in range(len(centres)):
        S = shapes[e]
        x, y, z = eye[0] - centres[e, 0], eye[1] - centres[e, 1], eye[2] - centres[e, 2]
        o0 = S[0, 0] * x + S[0, 1] * y + S[0, 2] * z
        o1 = S[1, 0] * x + S[1, 1] * y + S[1, 2] * z
        o2 = S[2, 0] * x + S[2, 1] * y + S[2, 2] * z
        rest = o0 * o0 + o1 * o1 + o2 * o2 - 1
        if rest <= 0:
            continue  # the lens is inside
        largest = 1 / np.sqrt(np.min(np.sum(S * S, axis=1)))
        far = np.sqrt(x * x + y * y + z * z)
        left = -turned[0, 1] * x - turned[1, 1] * y
        ahead = -turned[0, 0] * x - turned[1, 0] * y
        away = max(np.hypot(left, ahead), 1e-9)
        off = np.arctan2(away, -z)
        spread = np.arcsin(min(largest / far, 1.0)) if far > largest else np.pi / 2
        narrow = np.cos(spread)
        most = min(off + spread, np.pi)
        radius = reach * spread * max(1.0, most / max(np.sin(min(most, 1.9)), 1e-3)) + 2
        u, v = middle - reach * off * left / away, middle + reach * off * ahead / away
        top, west = int(min(size, max(0.0, v - radius))), int(min(size, max(0.0, u - radius)))
        bottom = min(size - 1, int(min(size, max(-2.0, v + radius))) + 1)
        east = min(size - 1, int(min(size, max(-2.0, u + radius))) + 1)
        for row in range(top, bottom + 1):
            for column in range(west, east + 1):
                level, rise = rays[row, column, 2], rays[row, column, 3]
                a = level * (
                    turned[0, 0] * rays[row, column, 0] + turned[0, 1] * rays[row, column, 1]
                )
                b = level * (
                    turned[1, 0] * rays[row, column, 0] + turned[1, 1] * rays[row, column, 1]
                )
                if a * x + b * y + rise * z > -far * narrow:
                    continue
                d0 = S[0, 0] * a + S[0, 1] * b + S[0, 2] * rise
                d1 = S[1, 0] * a + S[1, 1] * b + S[1, 2] * rise
                d2 = S[2, 0] * a + S[2, 1] * b + S[2, 2] * rise
                square, half = d0 * d0 + d1 * d1 + d2 * d2, d0 * o0 + d1 * o1 + d2 * o2
                inner = half * half - square * rest
                if inner < 0 or half >= 0:
                    continue
                depth = (-half - np.sqrt(inner)) / square
                if depth >= depths[row, column]:
                    continue
                f, s, t = o0 + depth * d0, o1 + depth * d1, o2 + depth * d2
                owner = -1
                skin[:] = paint[e]
                if heads[e] > 0:
                    owner = owners[e] if _face(heads[e], f, s, t, hair[e], skin) else -1
                n0 = S[0, 0] * f + S[1, 0] * s + S[2, 0] * t
                n1 = S[0, 1] * f + S[1, 1] * s + S[2, 1] * t
                n2 = S[0, 2] * f + S[1, 2] * s + S[2, 2] * t
                n2 /= np.sqrt(n0 * n0 + n1 * n1 + n2 * n2)
                facing = -half / np.sqrt(square * (rest + 1))
                shade = (0.62 + 0.3 * n2) * (0.8 + 0.2 * min(1.0, max(facing, 0.0)))
                depths[row, column] = depth
                whose[row, column], lit[row, column] = owner, lights[e]
                for channel in range(3):
                    colours[row, column, channel] = skin[channel] * shade


@kernel()
def _face(kind, f, s, t, hair, skin):
    """Turn the skin of a head at a place of the unit sphere to hair, eyes or mouth; tell whether
    it is skin that a camera would call so.
    """
    short = f > 0.05 + 0.35 * abs(s) * (t > 0.1) and t < 0.58
    nape = kind == 1 and t < -0.62
    if kind == 2:
        short = f > 0.45 and t < 0.6
    if not (short or nape):
        skin[:] = hair
        return False
    if f < 0.3:
        return True
    side = abs(s) - 0.36
    if (side / 0.15) ** 2 + ((t - 0.1) / 0.07) ** 2 < 1:  # eyes
        skin[:] = 0.03
        return False
    if abs(side) < 0.2 and 0.2 < t < 0.27:  # brows
        skin[:] = hair
        return False
    if (s / 0.3) ** 2 + ((t + 0.45) / 0.07) ** 2 < 1:  # mouth
        skin[0] *= 0.5
        skin[1] *= 0.45
        skin[2] *= 0.75
    elif abs(s) < 0.12 and -0.25 < t < -0.15:  # below the nose
        for channel in range(3):
            skin[channel] *= 0.6
    return True


@kernel()
def _gathered(fine, lit, light, parts):
    """Means of square blocks in their light; a ray that saturates counts as twice full light."""
    size = fine.shape[0] // parts
    image = np.zeros((size, size, 3), dtype=np.float32)
    for row in range(size * parts):
        for column in range(size * parts):
            which = lit[row, column]
            for channel in range(3):
                value = min(fine[row, column, channel] * light[which, channel], 2.0)
                image[row // parts, column // parts, channel] += value / parts**2
    return image


@kernel()
def _develop(light, fall, gain, read, photon, noise, table, image):
    """Grey values of light with a fall-off and noise, which the gain multiplies too."""
    last = len(table) - 1
    for row in range(image.shape[0]):
        for column in range(image.shape[1]):
            for channel in range(3):
                value = light[row, column, channel] * fall[row, column]
                value += noise[row, column, channel] * np.sqrt(
                    read * read + photon * max(value, 0.0)
                )
                value = min(1.0, max(0.0, value * gain))  # in this order NaN is dark
                image[row, column, channel] = table[int(value * last + 0.5)]
