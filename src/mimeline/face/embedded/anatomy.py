"""Where the parts of the embedded face are.

Centimetres; +X the subject's left, +Y up, +Z forward; y = 0 at the pupils, z = 0 amid the skull.
Only the left half (x >= 0) is told; the right half is its mirror image.
"""

EYE = (3.18, 0.0, 6.14)
EYE_RADIUS = 1.62
IRIS_RADIUS = 0.74
PUPIL_RADIUS = 0.3
LID_THICKNESS = 0.13
LID_CORNER = 1.54  # half the width of the opening
UPPER_LID, LOWER_LID = 0.68, 0.62  # how far the opening reaches above and below the pupil

MOUTH = (-7.0, 2.45)  # height of the line where the lips meet, and x of the corner
UPPER_LIP, LOWER_LIP = 0.6, 0.8  # height of the red on the midline

HINGE_AT = (0.0, -1.8, 0.6)  # the axis of the jaw, before the ears
NECK_BOTTOM = -14.8

# Points of the hairline, from the forehead over the temple and behind the ear to the nape.
HAIRLINE = (
    (0, 6.5, 7.6),
    (2.4, 6.2, 7.15),
    (4.5, 5.3, 6.1),
    (5.8, 3.9, 4.9),
    (6.4, 2.0, 4.0),
    (6.75, -0.1, 2.8),
    (6.9, -0.8, 2.2),
    (7.0, 0.2, 1.3),
    (7.1, 2.0, -0.5),
    (7.0, 1.0, -2.6),
    (6.3, -3.2, -3.4),
    (4.7, -6.7, -5.1),
    (2.4, -8.2, -6.5),
    (0, -8.5, -6.8),
)
HAIR_CENTRE = (0.0, 1.5, -1.0)
HAIR_AXIS = (0.0, 0.8, -0.6)  # from there to the middle of the hair

# Points of the bald head without nose, lips and lids: a thin plate is laid through them.
HEAD_POINTS = (
    # midline, from the crown down the front
    (0, 11.2, -1.0),
    (0, 9.7, 4.3),
    (0, 7.0, 7.3),
    (0, 4.8, 8.5),
    (0, 2.8, 9.0),
    (0, 1.5, 9.1),
    (0, 0.2, 8.7),
    (0, -2.0, 8.9),
    (0, -4.6, 9.4),
    (0, -5.6, 9.6),
    (0, -7.0, 9.55),
    (0, -8.5, 9.0),
    (0, -9.7, 9.5),
    (0, -10.7, 9.0),
    (0, -11.3, 7.6),
    (0, -11.5, 5.4),
    (0, -12.6, 3.9),
    (0, -15.5, 3.7),
    (0, -18.0, 3.5),
    # midline, from the crown down the back
    (0, 10.2, -6.0),
    (0, 6.0, -9.3),
    (0, 2.0, -9.8),
    (0, -3.0, -8.6),
    (0, -7.0, -7.0),
    (0, -11.0, -6.3),
    (0, -15.5, -6.6),
    (0, -18.0, -7.0),
    # forehead and brow
    (3.12, 5.8, 7.5),
    (3.33, 3.4, 8.3),
    (5.51, 5.0, 5.5),
    (5.93, 2.8, 6.1),
    (1.66, 1.8, 8.9),
    (3.33, 2.0, 8.6),
    (4.89, 1.7, 7.7),
    (5.93, 0.9, 6.4),
    # eye socket
    (3.22, 0.0, 7.4),
    (1.66, 0.0, 7.7),
    (4.89, 0.0, 6.8),
    (3.22, 1.1, 8.0),
    (3.22, -1.2, 7.8),
    (1.77, -1.0, 8.0),
    # cheek
    (5.82, -1.6, 6.5),
    (6.86, -0.8, 4.2),
    (4.16, -2.3, 7.8),
    (2.5, -2.0, 8.3),
    (3.54, -4.2, 8.1),
    (5.41, -4.4, 6.2),
    (6.66, -4.0, 3.2),
    (2.29, -5.0, 8.7),
    (2.81, -7.0, 8.45),
    (4.68, -7.2, 6.5),
    (5.82, -6.9, 2.8),
    # chin and jaw
    (2.08, -9.6, 8.3),
    (3.59, -9.4, 6.6),
    (4.99, -8.8, 3.4),
    (1.46, -10.9, 8.0),
    (2.91, -10.8, 6.1),
    (4.32, -9.9, 3.6),
    (5.41, -8.3, 1.0),
    (1.87, -11.3, 5.0),
    (3.22, -10.9, 3.0),
    (4.42, -10.5, 0.9),
    # temple and side
    (6.86, 3.0, 3.2),
    (7.07, 1.0, 2.8),
    (7.38, 0.0, 0.5),
    (7.38, 4.0, -1.5),
    (6.45, 8.0, -1.5),
    (7.49, 0.0, -3.0),
    (7.07, -3.0, 0.8),
    (6.55, -5.5, -0.3),
    # neck
    (5.1, -9.0, -1.2),
    (4.52, -12.0, -1.4),
    (4.58, -15.5, -1.6),
    (5.2, -18.0, -1.8),
    (2.86, -13.0, 2.5),
    (2.86, -15.5, 2.2),
    (3.22, -18.0, 2.0),
    (3.54, -12.0, -4.9),
    (3.54, -15.5, -5.1),
    (3.95, -18.0, -5.4),
    # back of the head
    (6.86, 3.0, -5.5),
    (4.68, 3.0, -8.6),
    (5.62, 7.5, -5.0),
    (6.24, -2.5, -5.0),
    (4.68, -6.0, -5.6),
    (4.06, 8.8, 3.0),
    (3.74, 10.2, -1.0),
    (3.12, 9.1, -5.8),
)

NECK_AT = (0.0, NECK_BOTTOM, -1.5)
HEAD_AT = (0.0, -7.5, -2.0)  # where the head turns on the neck

# Landmarks 16 to 9 of the jaw line, from the ear down, and 27 to 30 of the nose.
JAW_LINE = (
    (6.9, -0.8, 1.7),
    (6.6, -2.9, 1.8),
    (6.3, -5.0, 2.0),
    (5.7, -7.0, 2.4),
    (5.0, -8.7, 3.4),
    (4.3, -9.9, 4.6),
    (3.0, -10.7, 6.2),
    (1.5, -11.0, 7.6),
)
NOSE_BRIDGE = ((0, 0.1, 9.2), (0, -1.1, 9.8), (0, -2.3, 10.5), (0, -3.5, 11.2))

# Places where vertices lie close, and how close.
DENSE = (
    ((0.4, -3.9, 10.3), 0.32),
    ((0.9, -4.1, 9.6), 0.32),
    ((0.0, -1.5, 9.8), 0.44),
    ((1.0, -1.2, 9.0), 0.40),
    ((2.6, -7.0, 8.8), 0.50),
    ((2.8, -5.4, 8.3), 0.42),
)
