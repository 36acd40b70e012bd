"""Files of other people's models with random numbers in them, in the layouts that they have."""

import numpy as np
import pytest

from mimeline.face.formats import ict

V = 40  # vertices of a small FLAME


def published(**change) -> dict[str, np.ndarray]:
    """FLAME's arrays; None takes one away."""
    rng = np.random.default_rng(0)
    weights = np.zeros((V, 5))
    weights[:20] = rng.dirichlet(np.ones(5), 20)
    weights[20:30, 3] = weights[30:, 4] = 1  # the eyeballs
    template = rng.normal(0, 0.1, (V, 3))
    regressor = rng.dirichlet(np.ones(V), 5)
    arrays = {
        "v_template": template,
        "shapedirs": rng.normal(0, 0.01, (V, 3, 400)),
        "posedirs": rng.normal(0, 0.01, (V, 3, 36)),
        "J_regressor": regressor,
        "J": regressor @ template,
        "weights": weights,
        "kintree_table": np.array([[2**32 - 1, 0, 1, 1, 1], [0, 1, 2, 3, 4]], dtype=np.uint32),
        "f": rng.integers(0, V, (30, 3)).astype(np.uint32),
    }
    return {name: value for name, value in (arrays | change).items() if value is not None}


@pytest.fixture(scope="session")
def like_ict() -> dict[str, np.ndarray]:
    """The arrays of a packed ICT-FaceKit: a ball of random vertices, one shape, one identity."""
    rng = np.random.default_rng(0)
    neutral = rng.normal(size=(ict.N_VERTICES, 3))
    neutral *= 15 / np.linalg.norm(neutral, axis=1, keepdims=True)  # centimetres
    return {
        "neutral": neutral.astype(np.float32),
        "quads": rng.integers(0, ict.N_VERTICES, (200, 4)),
        "expr_names": np.array(["jawOpen"]),
        "expr_delta": rng.normal(size=(1, ict.N_VERTICES, 3)).astype(np.float32),
        "ident_names": np.array(["identity000"]),
        "ident_delta_face": rng.normal(size=(1, ict.N_FACE, 3)).astype(np.float32),
    }
