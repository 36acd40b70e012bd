"""What a toy person looks and sounds like: face, colours and the pitch of the voice."""

from dataclasses import dataclass

import numpy as np

from mimeline.face.embedded import embedded_face
from mimeline.face.model import Face
from mimeline.toy.garment import dressed

Colour = tuple[int, int, int]  # sRGB

BLACK, DARK_BROWN, BROWN = (35, 28, 26), (62, 42, 32), (102, 68, 44)
AUBURN, COPPER, BLOND = (124, 60, 38), (176, 92, 48), (206, 166, 104)
GREY, WHITE = (142, 140, 138), (216, 212, 204)
DARK_IRIS, BROWN_IRIS, HAZEL = (58, 38, 26), (98, 62, 34), (128, 98, 52)
GREEN_IRIS, BLUE_IRIS, GREY_IRIS = (86, 122, 84), (78, 124, 168), (124, 142, 152)

# Complexions: skin, the hair and the irises that go with it.
COMPLEXIONS: tuple[tuple[Colour, tuple[Colour, ...], tuple[Colour, ...]], ...] = (
    ((242, 204, 184), (COPPER, BLOND, AUBURN, WHITE), (BLUE_IRIS, GREEN_IRIS, GREY_IRIS)),
    ((232, 188, 160), (BLOND, BROWN, DARK_BROWN, GREY), (BLUE_IRIS, HAZEL, GREEN_IRIS)),
    ((224, 174, 140), (BLACK, BROWN, DARK_BROWN, GREY), (BROWN_IRIS, HAZEL, DARK_IRIS)),
    ((204, 150, 112), (BLACK, DARK_BROWN, AUBURN, WHITE), (BROWN_IRIS, DARK_IRIS, GREEN_IRIS)),
    ((172, 118, 82), (BLACK, DARK_BROWN, GREY), (DARK_IRIS, BROWN_IRIS)),
    ((136, 88, 60), (BLACK, DARK_BROWN, GREY), (DARK_IRIS, BROWN_IRIS)),
    ((98, 64, 46), (BLACK, BLACK, WHITE), (DARK_IRIS,)),
)
BACKGROUNDS: tuple[Colour, ...] = (
    (190, 208, 224),
    (204, 220, 204),
    (228, 220, 200),
    (210, 202, 224),
    (166, 194, 198),
    (226, 206, 206),
    (140, 160, 180),
    (164, 180, 152),
    (232, 232, 228),
    (186, 174, 166),
    (120, 136, 140),
)
CLOTHES: tuple[Colour, ...] = (
    (44, 66, 108),
    (138, 46, 54),
    (48, 104, 84),
    (226, 220, 206),
    (204, 152, 62),
    (108, 80, 136),
    (52, 124, 140),
    (62, 64, 70),
    (190, 104, 92),
)
IDENTITY = 0.7  # largest weight of an identity shape: eyes close in any mixture
PITCH_HZ = (85.0, 235.0)


@dataclass(frozen=True)
class Appearance:
    """identity: weights of the embedded face's identity shapes. pitch_hz: of the voice."""

    identity: dict[str, float]
    skin: Colour
    hair: Colour
    iris: Colour
    clothes: Colour
    pitch_hz: float

    def face(self) -> Face:
        """The person's own face, above a pullover."""
        bare = embedded_face(skin=self.skin, hair=self.hair, iris=self.iris).of(self.identity)
        return dressed(bare, self.clothes)


def appearance(number: int, seed: int) -> Appearance:
    """The looks of the numbered person of a world; neighbours differ in complexion."""
    rng = np.random.default_rng([seed, 6, number])
    skin, hairs, irises = COMPLEXIONS[(seed + 3 * number) % len(COMPLEXIONS)]
    names = embedded_face().identity_names
    weights = rng.uniform(-IDENTITY, IDENTITY, len(names))
    low, high = np.log(PITCH_HZ)
    return Appearance(
        identity=dict(zip(names, weights.tolist(), strict=True)),
        skin=skin,
        hair=hairs[rng.integers(len(hairs))],
        iris=irises[rng.integers(len(irises))],
        clothes=CLOTHES[rng.integers(len(CLOTHES))],
        pitch_hz=float(np.exp(rng.uniform(low, high))),
    )


def background(source: str, seed: int) -> Colour:
    """The wall behind the people of a source video."""
    rng = np.random.default_rng([seed, 7, *source.encode()])
    return BACKGROUNDS[rng.integers(len(BACKGROUNDS))]
