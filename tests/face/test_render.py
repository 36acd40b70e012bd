import numpy as np
import pytest

from mimeline.face.model import Face, Joint
from mimeline.face.render import BACKGROUND, Camera, draw, film, strip
from mimeline.face.rotations import turned

RED, GREEN, BLUE = np.uint8([(200, 0, 0), (0, 200, 0), (0, 0, 200)])


def squares(*placed):
    """A face of squares that look forward. placed: (x, y, z, half edge, colour)."""
    corners = np.float32([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)])
    neutral = np.concatenate([half * corners + (x, y, z) for x, y, z, half, _ in placed])
    triangles = np.concatenate([np.add([(0, 1, 2), (0, 2, 3)], 4 * n) for n in range(len(placed))])
    return Face(
        neutral=neutral,
        triangles=triangles,
        shapes=np.zeros((0, len(neutral), 3)),
        shape_names=[],
        joints=[Joint("head", None, np.zeros(3))],
        skin=np.ones((len(neutral), 1)),
        colours=np.repeat([colour for *_, colour in placed], 4, axis=0),
    )


def drawn(face, size=64, background=BACKGROUND):
    return draw(face, face.neutral, Camera.framing(face, size), background)


def test_the_subjects_left_is_on_the_pictures_right_and_up_is_up():
    placed = (0.05, 0, 0, 0.04, RED), (-0.05, 0, 0, 0.04, GREEN), (0, 0.1, 0, 0.04, BLUE)
    picture = drawn(squares(*placed), background=(0, 0, 0))
    red, green, blue = (np.argwhere(picture[..., n] > 100).mean(0) for n in range(3))
    assert red[1] > 32 > green[1]
    assert blue[0] < red[0]


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_nearer_surfaces_hide_farther_ones(order):
    pair = [(0, 0, 0, 0.1, RED), (0, 0, -0.05, 0.1, GREEN)]
    picture = drawn(squares(*(pair[n] for n in order)))
    assert picture[32, 32, 0] > 100 > picture[32, 32, 1]


def test_the_background_is_untouched_where_there_is_no_face(ball_face):
    picture = drawn(ball_face, background=(10, 200, 30))
    free = (picture == (10, 200, 30)).all(-1)
    rows, columns = np.mgrid[:64, :64]
    outside = np.hypot(rows - 31.5, columns - 31.5) > 30
    assert free[outside].all() and not free[28:36, 28:36].any()


def test_edges_are_softened():
    face = squares((0, 0, 0, 0.1, RED))
    slanted = face.vertices(np.zeros((1, 0)), {"head": turned([0], [0], [0.3])})[0]
    green = draw(face, slanted, Camera.framing(face, 64), (255, 255, 255))[..., 1].astype(int)
    mixed = (green > green[32, 32] + 10) & (green < 245)
    assert 60 < mixed.sum() < 300  # along the edges, and nowhere else


def test_the_same_picture_comes_twice(ball_face):
    assert drawn(ball_face, 96).tobytes() == drawn(ball_face, 96).tobytes()


def test_a_surface_seen_from_inside_is_dark():
    face, camera = squares((0, 0, 0, 0.1, RED)), Camera.framing(squares((0, 0, 0, 0.1, RED)), 32)
    away = face.vertices(np.zeros((1, 0)), {"head": turned([np.pi], [0], [0])})[0]
    outside, inside = draw(face, face.neutral, camera), draw(face, away, camera)
    assert 0 < inside[16, 16, 0] < 0.5 * outside[16, 16, 0]


def test_light_comes_from_above(ball_face):
    picture = drawn(ball_face).astype(int).sum(-1)
    assert picture[20, 32] > picture[44, 32] + 60


def test_a_point_is_drawn_where_the_camera_projects_it():
    face = squares((0.03, 0.02, 0, 0.01, RED), (-0.05, -0.05, 0, 0.01, GREEN))
    picture = drawn(face, 200)
    red = np.argwhere((picture[..., 0] > 100) & (picture[..., 1] < 100))
    column, row = Camera.framing(face, 200).project(face.neutral[:4].mean(0))
    np.testing.assert_allclose(red.mean(0) + 0.5, (row, column), atol=0.6)


def test_the_camera_frames_the_head_and_not_the_shoulders():
    face = squares((0, 0, 0, 0.1, RED), (0, -0.3, 0, 0.3, GREEN))
    skin = np.repeat(np.eye(2), 4, axis=0)
    joints = [Joint("head", None, np.zeros(3)), Joint("neck", None, np.zeros(3))]
    bust = Face(
        neutral=face.neutral,
        triangles=face.triangles,
        shapes=face.shapes,
        shape_names=[],
        joints=joints,
        skin=skin,
    )
    rows = Camera.framing(bust, 100).project(face.neutral[:4])[:, 1]
    assert rows.min() == pytest.approx(10, abs=1) and rows.max() == pytest.approx(90, abs=1)


def test_what_lies_behind_the_camera_or_outside_the_picture_is_not_drawn(ball_face):
    camera = Camera.framing(ball_face, 64)
    for shift in ((0, 0, 5), (9, 0, 0), (0, -9, 0)):
        picture = draw(ball_face, ball_face.neutral + np.float32(shift), camera)
        assert (picture == BACKGROUND).all()


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e20, 3e38])
def test_vertices_without_bounds_do_no_harm(ball_face, value):
    camera, wild = Camera.framing(ball_face, 32), np.random.default_rng(0)
    for axes in ([0], [1], [2], [0, 1, 2]):
        vertices = ball_face.neutral.copy()
        chosen = wild.random(len(vertices)) < 0.3
        vertices[np.ix_(chosen, axes)] = value * wild.choice([-1, 1], (chosen.sum(), len(axes)))
        assert draw(ball_face, vertices, camera).shape == (32, 32, 3)
    assert (draw(ball_face, np.full_like(vertices, value), camera) == BACKGROUND).all()


def test_a_film_is_one_picture_a_frame_made_as_it_is_asked_for(ball_face):
    camera = Camera.framing(ball_face, 32)
    frames = iter([ball_face.neutral, np.zeros((3, 3))])
    pictures = film(ball_face, frames, camera)
    assert (next(pictures) == draw(ball_face, ball_face.neutral, camera)).all()
    with pytest.raises(ValueError, match=r"vertices have shape \(3, 3\)"):
        next(pictures)


def test_a_strip_is_the_pictures_side_by_side():
    pictures = [np.full((4, 3, 3), n, np.uint8) for n in range(5)]
    joined = strip(pictures)
    assert joined.shape == (4, 15, 3)
    np.testing.assert_array_equal(joined[0, ::3, 0], range(5))
