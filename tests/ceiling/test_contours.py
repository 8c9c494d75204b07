"""Contours: edges and their gradients, chains of pixels, segments and arcs of drawn shapes."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from robot_perception.ceiling.contours import (
    Arc,
    ContourRules,
    Edges,
    Segment,
    _arc,
    _corners,
    _link,
    find_contours,
    find_edges,
)
from tests.ceiling.pictures import drawn, rectangle, smooth
from tests.unchecked import unchecked

ROUND = ContourRules(roundness=0.9)
"""With 0.8, the default, 3 of 100 circles come in pieces."""


def found(image, rules=None):
    return find_contours(find_edges(image, rules), rules)


def kinds(pieces, kind):
    return [piece for piece in pieces if isinstance(piece, kind)]


def from_line(points, start, end):
    """Return how far points are from the segment between two points."""
    start, along = np.asarray(start), np.subtract(end, start)
    t = np.clip((points - start) @ along / (along @ along), 0, 1)
    return np.hypot(*(points - start - t[:, None] * along).T)


def from_pieces(points, pieces):
    """Return how far each point is from the nearest piece."""
    along = np.concatenate([piece.points(0.2) for piece in pieces])
    return np.array([np.hypot(*(along - point).T).min() for point in points])


# Pieces ------------------------------------------------------------------------------------------


coordinates = st.tuples(st.floats(-50, 50), st.floats(-50, 50))


@given(coordinates, coordinates, st.floats(0.1, 40))
@settings(max_examples=50)
def test_points_of_a_segment(start, end, spacing):
    if np.hypot(*np.subtract(start, end)) < 1e-3:
        return
    segment = Segment(start, end)
    points = segment.points(spacing)
    np.testing.assert_allclose(points[[0, -1]], [start, end], atol=1e-12)
    gaps = np.hypot(*np.diff(points, axis=0).T)
    assert gaps.max() <= spacing + 1e-9
    assert np.ptp(gaps) <= 1e-9
    assert gaps.sum() == pytest.approx(segment.length)
    assert len(points) <= segment.length / spacing + 2  # and no more than that needs
    assert from_line(points, start, end).max() <= 1e-9


@given(
    coordinates,
    st.floats(0.5, 60),
    st.floats(-7, 7),
    st.floats(-2 * np.pi, 2 * np.pi).filter(lambda sweep: abs(sweep) > 1e-3),
    st.floats(0.1, 40),
)
@settings(max_examples=50)
def test_points_of_an_arc(centre, radius, start, sweep, spacing):
    arc = Arc(centre, radius, start, sweep)
    points = arc.points(spacing)
    np.testing.assert_allclose(np.hypot(*(points - centre).T), radius)
    ends = np.array([start, start + sweep])
    expected = centre + radius * np.column_stack([np.cos(ends), np.sin(ends)])
    np.testing.assert_allclose(points[[0, -1]], expected, atol=1e-9)
    assert np.hypot(*np.diff(points, axis=0).T).max() <= spacing + 1e-9
    assert arc.length == pytest.approx(radius * abs(sweep))
    fine = arc.points(0.01 * radius)
    chords = np.hypot(*np.diff(fine, axis=0).T).sum()
    assert chords == pytest.approx(arc.length, rel=1e-4)


def test_a_positive_sweep_turns_from_u_to_v():
    np.testing.assert_allclose(
        Arc((5, 6), 2, 0, np.pi / 2).points(10), [[7, 6], [5 + 2**0.5, 6 + 2**0.5], [5, 8]][::2]
    )


# Edges -------------------------------------------------------------------------------------------


def test_the_gradient_of_a_ramp():
    v, u = np.indices((60, 80))
    edges = find_edges((2 * u + v).astype(np.uint8))
    np.testing.assert_allclose(edges.gradient[5:-5, 5:-5], [[[2.0, 1.0]] * 70] * 50, atol=0.13)
    assert not edges.mask.any()


def test_the_gradient_is_that_of_the_smoothed_picture():
    from scipy.ndimage import gaussian_filter

    image = smooth(1, 3.0)
    for sigma in (1.0, 2.5):
        field = gaussian_filter(image.astype(float), sigma, mode="nearest")
        edges = find_edges(image, ContourRules(smoothing=sigma))
        along_v, along_u = np.gradient(field)
        inside = np.s_[5:-5, 5:-5]
        assert np.abs(edges.gradient[..., 0] - along_u)[inside].max() < 1.2
        assert np.abs(edges.gradient[..., 1] - along_v)[inside].max() < 1.2
        assert np.abs(edges.gradient[..., 0] - along_u)[inside].mean() < 0.15


@pytest.mark.parametrize(("dark", "light"), [(60, 200), (200, 60)])
def test_gradients_point_to_the_light(dark, light):
    image = drawn([("disc", (160.3, 119.6, 40), dark)], ground=light)
    phi = np.linspace(-3, 3, 50)
    out = np.stack([np.cos(phi), np.sin(phi)], axis=-1)
    seen = find_edges(image).directions((160.3, 119.6) + 40 * out)
    expected = out if light > dark else -out
    assert ((np.cos(seen) * expected[:, 0] + np.sin(seen) * expected[:, 1]) > 0.98).all()


def test_directions_are_those_of_the_nearest_pixel():
    gradient = np.random.default_rng(0).normal(size=(5, 7, 2))
    edges = Edges(np.zeros((5, 7), bool), gradient)
    points = np.array([[2.4, 3.6], [-9.0, 1.0], [100.0, 100.0]])
    nearest = gradient[[4, 1, 4], [2, 0, 6]]
    np.testing.assert_allclose(edges.directions(points), np.arctan2(nearest[:, 1], nearest[:, 0]))


def test_an_edge_begins_at_the_high_threshold_and_goes_on_to_the_low_one():
    u, v = np.arange(80), np.arange(200)
    contrast = 100 - 0.5 * v
    image = np.where(u < 40, 50, 50 + contrast[:, None]).astype(np.uint8)
    for low, high in ((4.0, 10.0), (8.0, 15.0), (8.0, 50.0)):
        edges = find_edges(image, ContourRules(low=low, high=high))
        strength = np.hypot(*np.moveaxis(edges.gradient, -1, 0)).max(axis=1)
        assert strength.max() == pytest.approx(100 * 0.3125, rel=0.05)  # Φ(½) - Φ(-3/2), over 2
        rows = edges.mask[2:-2].any(axis=1)
        expected = strength[2:-2] > low if strength.max() > high else np.zeros_like(rows)
        assert (rows != expected).sum() <= 2


# Chains ------------------------------------------------------------------------------------------


def chains_of(mask):
    labels, order = _link(mask.astype(np.uint8))
    return labels, order, [order[labels == k] for k in range(labels.max(initial=-1) + 1)]


@given(arrays(bool, st.tuples(st.integers(1, 12), st.integers(1, 12))))
@settings(max_examples=300)
def test_chains_hold_each_pixel_once_and_go_from_neighbour_to_neighbour(mask):
    labels, order, chains = chains_of(mask)
    v, u = np.nonzero(mask)
    np.testing.assert_array_equal(order[np.lexsort(order.T)], np.column_stack([u, v]))
    assert not len(labels) or labels[0] == 0
    assert np.isin(np.diff(labels), (0, 1)).all()
    taken = np.zeros((mask.shape[0] + 2, mask.shape[1] + 2), bool)
    for chain in chains:
        assert (np.abs(np.diff(chain, axis=0)).max(axis=1, initial=1) == 1).all()
        taken[chain[:, 1] + 1, chain[:, 0] + 1] = True
        u, v = chain[-1]
        around = np.pad(mask, 1)[v : v + 3, u : u + 3] & ~taken[v : v + 3, u : u + 3]
        assert not around.any()  # a chain ends where it cannot go on


@given(st.lists(st.sampled_from([-1, 0, 1]), min_size=1, max_size=30), st.booleans())
def test_a_path_is_one_chain_from_end_to_end(steps, upright):
    path = np.column_stack([np.arange(len(steps) + 1), 31 + np.cumsum([0, *steps])])
    path = path[:, ::-1] if upright else path
    mask = np.zeros((64, 64), bool)
    mask[path[:, 1], path[:, 0]] = True
    _, order, chains = chains_of(mask)
    assert len(chains) == 1
    np.testing.assert_array_equal(order if (order[0] == path[0]).all() else order[::-1], path)


def test_a_closed_outline_is_one_chain():
    mask = np.zeros((20, 20), bool)
    mask[3:15, 4:18] = True
    mask[4:14, 5:17] = False
    _, order, chains = chains_of(mask)
    assert len(chains) == 1
    assert np.abs(order[0] - order[-1]).max() == 1


@given(st.integers(0, 2**32 - 1), st.sampled_from([0.8, 1.5, 3.0]))
@settings(max_examples=30)
def test_a_chain_leaves_its_polygon_by_the_tolerance(seed, tolerance):
    rng = np.random.default_rng(seed)
    v = np.rint(60 + np.cumsum(np.cumsum(rng.normal(0, 0.15, 80)))).clip(0, 500).astype(int)
    mask = np.zeros((512, 80), bool)
    last = v[0]
    for u, row in enumerate(v):  # steep parts are filled
        mask[min(last, row) : max(last, row) + 1, u] = True
        last = row
    for chain in chains_of(mask)[2]:
        if len(chain) < 12:
            continue
        corners = _corners(chain, tolerance)
        assert corners[0] == 0
        assert corners[-1] == len(chain) - 1
        assert (np.diff(corners) > 0).all()
        for a, b in pairwise(corners):
            inner = chain[a : b + 1].astype(float)
            # OpenCV leaves out a corner at last whose neighbours are nearly in line
            assert from_line(inner, inner[0], inner[-1]).max() <= 1.8 * tolerance


# Shapes ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "centre", [(150.0, 110.0), (150.5, 110.25), (149.7, 110.4)], ids=lambda c: f"{c}"
)
@pytest.mark.parametrize(("dark", "light"), [(60, 200), (190, 90)])
def test_a_rectangle_has_four_segments(centre, dark, light):
    corners = rectangle(*centre, 100, 60)
    pieces = found(drawn([("area", corners, dark)], ground=light))
    assert len(pieces) == 4
    sides = [(corners[k], corners[(k + 1) % 4]) for k in range(4)]
    near = []
    for piece in pieces:
        assert isinstance(piece, Segment)
        # a tolerance of 1.5 px, and the corners are rounded by the smoothing
        away = [from_line(np.array([piece.start, piece.end]), *side).max() for side in sides]
        middle = [from_line(piece.points(1.0)[[-1, 0]].mean(0)[None], *side)[0] for side in sides]
        near.append(int(np.argmin(away)))
        assert min(away) <= 2.0
        assert min(middle) <= 1.2
        side = sides[near[-1]]
        assert abs(piece.length - np.hypot(*(side[1] - side[0]))) <= 5
    assert sorted(near) == [0, 1, 2, 3]


@pytest.mark.parametrize("turned", [0.05, 0.3, 0.7, 1.2, 2.0])
def test_segments_lie_on_the_sides_of_a_turned_rectangle(turned):
    corners = rectangle(160.2, 120.4, 100, 60, turned)
    pieces = found(drawn([("area", corners, 60)]))
    assert 4 <= len(pieces) <= 8
    assert {type(piece) for piece in pieces} == {Segment}
    outline = [Segment(tuple(corners[k]), tuple(corners[(k + 1) % 4])) for k in range(4)]
    assert from_pieces(np.concatenate([p.points(2.0) for p in pieces]), outline).max() <= 2.0
    assert from_pieces(np.concatenate([p.points(2.0) for p in outline]), pieces).max() <= 4.0
    assert sum(piece.length for piece in pieces) == pytest.approx(320, abs=20)


@pytest.mark.parametrize("radius", [12, 20, 30, 45, 58])
@pytest.mark.parametrize("centre", [(160, 120), (160.3, 119.6)])
def test_a_circle_is_one_closed_arc(radius, centre):
    pieces = found(drawn([("disc", (*centre, radius), 60)]), ROUND)
    assert len(pieces) == 1
    (arc,) = pieces
    assert isinstance(arc, Arc)
    assert arc.radius == pytest.approx(radius, abs=0.3)
    np.testing.assert_allclose(arc.centre, centre, atol=0.3)
    assert 2 * np.pi - 2.5 / radius <= abs(arc.sweep) <= 2 * np.pi
    assert arc.sweep > 0  # the walk begins at the top and goes to the right
    assert np.sin(arc.start) < -0.9


@pytest.mark.parametrize("radius", [20, 30, 45])
def test_by_default_what_is_found_of_a_circle_lies_on_it(radius):
    pieces = found(drawn([("disc", (160, 120, radius), 60)]))
    arcs = kinds(pieces, Arc)
    assert arcs
    for arc in arcs:
        assert arc.radius == pytest.approx(radius, abs=0.8)
    along = np.concatenate([piece.points(1.0) for piece in pieces])
    assert np.abs(np.hypot(*(along - (160, 120)).T) - radius).max() <= 2.0
    assert sum(piece.length for piece in pieces) >= 0.9 * 2 * np.pi * radius


def test_a_rounded_shape_has_arcs_and_segments():
    shapes = [("disc", (u, 120, 30), 60) for u in (120, 220)]
    shapes.append(("area", rectangle(170, 120, 100, 60), 60))
    pieces = found(drawn(shapes), ROUND)
    arcs, segments = kinds(pieces, Arc), kinds(pieces, Segment)
    assert len(arcs) == 2
    assert sorted(arc.centre[0] for arc in arcs) == pytest.approx([120, 220], abs=2.5)
    for arc in arcs:
        assert arc.radius == pytest.approx(30, abs=1.5)
        assert abs(arc.sweep) == pytest.approx(np.pi, abs=0.8)
    long = [s for s in segments if s.length > 80]
    assert sorted(s.start[1] for s in long) == pytest.approx([90, 150], abs=1.5)


def test_an_arc_reaches_from_the_first_pixel_of_its_chain_to_the_last():
    angle = np.linspace(0.3, 2.6, 400)
    u, v = np.rint((100, 80) + 40 * np.column_stack([np.cos(angle), np.sin(angle)])).astype(int).T
    mask = np.zeros((200, 200), bool)
    mask[v, u] = True
    (arc,) = find_contours(Edges(mask, np.zeros((200, 200, 2))), ROUND)
    ends = np.array([arc.start, arc.start + arc.sweep])
    directions = np.stack([np.cos(ends), np.sin(ends)], axis=-1)
    for pixel in ((u[0], v[0]), (u[-1], v[-1])):
        way = np.subtract(pixel, arc.centre)
        assert (directions @ way / np.hypot(*way)).max() == pytest.approx(1, abs=1e-9)


def test_no_arc_is_larger_than_the_rules_say():
    image = drawn([("disc", (160, 120, 50), 60)])
    rules = ContourRules(largest=40, roundness=1.1)
    assert not kinds(found(image, rules), Arc)
    assert kinds(found(image, ContourRules(largest=51, roundness=1.1)), Arc)


def test_pieces_cover_the_edges_of_a_wavy_outline():
    angle = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    r = 60 + 8 * np.sin(5 * angle)
    corners = np.column_stack([160 + r * np.cos(angle), 120 + r * np.sin(angle)])
    rules = ContourRules(shortest=3)
    edges = find_edges(drawn([("area", corners, 40)]), rules)
    pieces = find_contours(edges, rules)
    pixels = np.argwhere(edges.mask)[:, ::-1]
    assert from_pieces(pixels, pieces).max() <= 2.3
    outline = Segment(tuple(corners[-1]), tuple(corners[0]))
    outlines = [Segment(tuple(a), tuple(b)) for a, b in pairwise(corners)]
    along = np.concatenate([piece.points(1.0) for piece in pieces])
    assert from_pieces(along, [outline, *outlines]).max() <= 2.3


def test_short_chains_are_dropped():
    edges = find_edges(drawn([("disc", (100, 100, 12), 60)]))
    (chain,) = chains_of(edges.mask)[2]
    for shortest, there in ((len(chain), True), (len(chain) + 1, False)):
        assert bool(find_contours(edges, ContourRules(shortest=shortest, roundness=1.1))) == there


@given(
    st.tuples(st.floats(-20, 20), st.floats(-20, 20)),
    st.floats(10, 55),
    st.floats(-3, 3),
    st.floats(0.7, 6.2),
    st.sampled_from([-1, 1]),
)
@settings(max_examples=60)
def test_the_circle_through_points_is_that_of_scipy(centre, radius, start, sweep, sign):
    from scipy.optimize import least_squares

    angle = start + sign * np.linspace(0, sweep, 60)
    exact = centre + radius * np.column_stack([np.cos(angle), np.sin(angle)])
    noise = np.random.default_rng(0).uniform(-0.1, 0.1, exact.shape)
    points = np.rint(100 * (exact + noise)).astype(np.int32)  # chains are of whole numbers
    arc = _arc(points, ContourRules(roundness=500.0, largest=1e5))
    points = points / 100
    arc = Arc(tuple(np.divide(arc.centre, 100)), arc.radius / 100, arc.start, arc.sweep)

    def residuals(circle):
        u, v = points.T
        return (u - circle[0]) ** 2 + (v - circle[1]) ** 2 - circle[2] ** 2  # what Kåsa minimises

    best = least_squares(residuals, [*centre, radius], xtol=1e-12, ftol=1e-12, gtol=1e-12).x
    np.testing.assert_allclose([*arc.centre, arc.radius], best, rtol=1e-3, atol=1e-3)
    np.testing.assert_allclose(
        arc.points(1e6), points[[0, -1]], atol=5 * abs(radius - arc.radius) + 0.8
    )
    assert np.sign(arc.sweep) == sign


def test_points_on_a_line_or_off_the_circle_are_no_arc():
    line = np.column_stack([np.arange(20), 2 * np.arange(20)]).astype(np.int32)
    assert _arc(line, ContourRules(largest=1e9)) is None
    angle = np.linspace(0, 3, 30)
    points = np.rint(20 * np.column_stack([np.cos(angle), np.sin(angle)])).astype(np.int32)
    assert _arc(points, ContourRules(largest=21)) is not None
    assert _arc(points, ContourRules(largest=19)) is None
    points[10] += (0, 2)
    assert _arc(points, ContourRules()) is None


# Bad input ---------------------------------------------------------------------------------------


def test_pictures_without_edges():
    for image in (np.full((50, 60), 9, np.uint8), np.zeros((1, 1), np.uint8)):
        edges = find_edges(image)
        assert not edges.mask.any()
        assert find_contours(edges) == ()


@pytest.mark.parametrize(
    ("made", "said"),
    [
        (lambda: Segment((1, 2), (1, 2)), "end must differ"),
        (lambda: Segment((1, np.nan), (1, 2)), "start must be finite"),
        (lambda: Arc((0, 0), 0, 0, 1), "radius must be positive"),
        (lambda: Arc((0, 0), 1, 0, 0), "sweep must be a turn"),
        (lambda: Arc((0, 0), 1, 0, -6.3), "sweep must be a turn"),
        (lambda: Segment((0, 0), (1, 0)).points(0), "spacing must be positive"),
        (lambda: Segment((0, 0), (1, 0)).points(1e-9), "spacing must cut"),
        (lambda: Arc((0, 0), 1, 0, 1).points(1e-320), "spacing must be at least 1e-100"),
        (lambda: ContourRules(low=5, high=4), "high must not be below low"),
        (lambda: ContourRules(shortest=2), "shortest must be from 3"),
        (lambda: ContourRules(smoothing=101), "smoothing must be at most 100, got 101"),
        (lambda: Edges(np.zeros((3, 3)), np.zeros((3, 3, 2))), "mask must be an array of truth"),
        (lambda: Edges(np.zeros((3, 3), bool), np.zeros((3, 4, 2))), "gradient must be"),
        (lambda: find_edges(np.zeros((3, 3))), "image must be an array of bytes"),
        (lambda: find_edges(np.zeros((3, 3, 3), np.uint8)), "image must be"),
        (lambda: find_edges(np.zeros((0, 3), np.uint8)), "image must have a pixel"),
        (lambda: find_contours(np.zeros((3, 3), bool)), "edges must be an Edges"),
        (lambda: find_edges(np.zeros((3, 3), np.uint8), 1.0), "rules must be a ContourRules"),
    ],
)
def test_bad_input_is_named(made, said):
    with unchecked(), pytest.raises((ValueError, TypeError), match=said):
        made()
