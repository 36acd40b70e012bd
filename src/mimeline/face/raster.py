"""The loops of the rasteriser: normals, which triangle each sample sees, the light of each pixel.

A pixel has 2 x 2 samples; those of its lower row lie half a sample further right, so that upright
edges have five shades. All arithmetic is float32 and in a fixed order: the same bytes each time.
"""

import numba
import numpy as np

ZERO, HALF, ONE, QUARTER = np.float32(0), np.float32(0.5), np.float32(1), np.float32(0.25)
TINY = np.float32(1e-12)
SLACK = np.float32(1e-5)  # of a triangle, against cracks between neighbours
BLOCK = 8  # samples
ACROSS = np.float32([0.25, 0.75])  # of a sample: where it lies in even and in odd rows
SHEEN_SQUARINGS = 5  # specular exponent 2^5
MIRRORED = np.float32(120)  # 1 / (1 - cosine) of the angle out to which a lamp is mirrored


@numba.njit(cache=True, error_model="numpy")
def vertex_normals(vertices, triangles):
    """Unit normals (V, 3): of the triangles around a vertex, weighted by their area."""
    normals = np.zeros_like(vertices)
    for t in range(len(triangles)):
        i, j, k = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        ax = vertices[j, 0] - vertices[i, 0]
        ay = vertices[j, 1] - vertices[i, 1]
        az = vertices[j, 2] - vertices[i, 2]
        bx = vertices[k, 0] - vertices[i, 0]
        by = vertices[k, 1] - vertices[i, 1]
        bz = vertices[k, 2] - vertices[i, 2]
        nx, ny, nz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
        for v in (i, j, k):
            normals[v, 0] += nx
            normals[v, 1] += ny
            normals[v, 2] += nz
    for v in range(len(normals)):
        x, y, z = normals[v, 0], normals[v, 1], normals[v, 2]
        length = np.sqrt(x * x + y * y + z * z)
        if length > ZERO:
            scale = ONE / length
            normals[v, 0], normals[v, 1], normals[v, 2] = x * scale, y * scale, z * scale
    return normals


@numba.njit(cache=True, error_model="numpy")
def cover(seen, triangles, nearest, owner):
    """Write 1 / distance and the number of the nearest triangle to every sample it covers.

    seen (V, 3): column and row in samples, 1 / distance (0 behind the camera) ·
    nearest (edge, edge) float32 zeros · owner (edge, edge) int32 filled with -1.

    Triangles seen from outside go first. Those seen from inside are mostly hidden then: they are
    skipped where every sample of the blocks around them is nearer.
    """
    edge = len(nearest)
    inner = np.empty(len(triangles), np.int32)
    n_inner = 0
    for t in range(len(triangles)):
        area = _area(seen, triangles, t)
        if area < ZERO:  # rows grow downwards: counter-clockwise is negative
            _fill(t, area, seen, triangles, nearest, owner)
        elif area > ZERO:
            inner[n_inner] = t
            n_inner += 1
    farthest = _farthest(nearest)
    for number in range(n_inner):
        t = inner[number]
        if not _hidden(t, seen, triangles, farthest, edge):
            _fill(t, _area(seen, triangles, t), seen, triangles, nearest, owner)


@numba.njit(cache=True, error_model="numpy")
def _farthest(nearest):
    """The least 1 / distance in each block of samples."""
    edge = len(nearest)
    n_blocks = (edge + BLOCK - 1) // BLOCK
    farthest = np.empty((n_blocks, n_blocks), np.float32)
    for block_row in range(n_blocks):
        for block_column in range(n_blocks):
            least = nearest[block_row * BLOCK, block_column * BLOCK]
            for row in range(block_row * BLOCK, min((block_row + 1) * BLOCK, edge)):
                for column in range(block_column * BLOCK, min((block_column + 1) * BLOCK, edge)):
                    least = min(least, nearest[row, column])
            farthest[block_row, block_column] = least
    return farthest


@numba.njit(cache=True, error_model="numpy")
def _area(seen, triangles, t):
    """Twice the area of a triangle in the picture; 0 also where a corner is behind the camera."""
    i, j, k = triangles[t, 0], triangles[t, 1], triangles[t, 2]
    if min(seen[i, 2], seen[j, 2], seen[k, 2]) <= ZERO:
        return ZERO
    ax, ay = seen[j, 0] - seen[i, 0], seen[j, 1] - seen[i, 1]
    bx, by = seen[k, 0] - seen[i, 0], seen[k, 1] - seen[i, 1]
    return ax * by - bx * ay


@numba.njit(cache=True, error_model="numpy")
def _bounds(t, seen, triangles, edge):
    """First and last column and row of samples around a triangle; in the picture, or empty."""
    i, j, k = triangles[t, 0], triangles[t, 1], triangles[t, 2]
    end = np.float32(edge)  # limits come before int(), which far numbers would overflow
    left = _limited(np.ceil(min(seen[i, 0], seen[j, 0], seen[k, 0]) - ACROSS[1]), ZERO, end)
    right = _limited(np.floor(max(seen[i, 0], seen[j, 0], seen[k, 0]) - ACROSS[0]), -ONE, end - ONE)
    top = _limited(np.ceil(min(seen[i, 1], seen[j, 1], seen[k, 1]) - HALF), ZERO, end)
    bottom = _limited(np.floor(max(seen[i, 1], seen[j, 1], seen[k, 1]) - HALF), -ONE, end - ONE)
    return left, right, top, bottom


@numba.njit(cache=True, error_model="numpy")
def _limited(value, low, high):
    return int(min(max(value, low), high))


@numba.njit(cache=True, error_model="numpy")
def _hidden(t, seen, triangles, farthest, edge):
    """Whether all samples of the blocks around a triangle are nearer than its nearest corner."""
    left, right, top, bottom = _bounds(t, seen, triangles, edge)
    i, j, k = triangles[t, 0], triangles[t, 1], triangles[t, 2]
    z = max(seen[i, 2], seen[j, 2], seen[k, 2])
    for row in range(top // BLOCK, bottom // BLOCK + 1):
        for column in range(left // BLOCK, right // BLOCK + 1):
            if farthest[row, column] < z:
                return False
    return True


@numba.njit(cache=True, error_model="numpy")
def _fill(t, area, seen, triangles, nearest, owner):
    """Take the samples that triangle t covers and that nothing nearer holds."""
    i, j, k = triangles[t, 0], triangles[t, 1], triangles[t, 2]
    left, right, top, bottom = _bounds(t, seen, triangles, len(nearest))
    x2, y2, z2 = seen[k, 0], seen[k, 1], seen[k, 2]
    scale = ONE / area
    a0, b0 = (seen[j, 1] - y2) * scale, (x2 - seen[j, 0]) * scale
    a1, b1 = (y2 - seen[i, 1]) * scale, (seen[i, 0] - x2) * scale
    dz0, dz1 = seen[i, 2] - z2, seen[j, 2] - z2
    slope = a0 * dz0 + a1 * dz1
    for row in range(top, bottom + 1):
        dx, dy = np.float32(left) + ACROSS[row & 1] - x2, np.float32(row) + HALF - y2
        w0, w1 = a0 * dx + b0 * dy, a1 * dx + b1 * dy
        first, last = _span(w0, a0, ZERO, np.float32(right - left))
        first, last = _span(w1, a1, first, last)
        first, last = _span(ONE - w0 - w1, -a0 - a1, first, last)
        if not first <= last:  # also where numbers are not finite
            continue
        z = z2 + w0 * dz0 + w1 * dz1
        for step in range(int(first), int(last) + 1):
            here = z + np.float32(step) * slope
            if here > nearest[row, left + step]:
                nearest[row, left + step] = here
                owner[row, left + step] = t


@numba.njit(cache=True, error_model="numpy")
def _span(weight, slope, first, last):
    """The whole steps from first to last at which weight + step * slope is not negative."""
    weight += SLACK
    if slope > ZERO:
        return max(first, np.ceil(-weight / slope)), last
    if slope < ZERO:
        return first, min(last, np.floor(-weight / slope))
    return first, (last if weight >= ZERO else -ONE)


@numba.njit(cache=True, error_model="numpy")
def shade(corners, triangles, owner, lights, ground, encoded, picture):
    """Fill the picture with the mean light of each pixel's samples, encoded to sRGB.

    A triangle is lit once in a pixel, at the middle of its samples there.
    corners (V, 9): column and row in samples, normal, linear albedo, gloss · owner as in `cover` ·
    lights (11, 3): see render.LIGHTS · ground (3,) linear background · encoded (n,) uint8 sRGB of
    linear light · picture (size, size, 3) uint8.
    """
    size = len(picture)
    places = np.empty((4 * size, 2), np.float32)  # of a row's pieces: column and row in samples
    shares = np.empty(4 * size, np.float32)
    pieces = np.empty((4 * size, 2), np.int32)  # triangle and pixel column
    lit = np.empty((4 * size, 3), np.float32)
    line = np.empty((size, 3), np.float32)
    for row in range(size):
        n_pieces = _split(owner[2 * row], owner[2 * row + 1], row, places, shares, pieces)
        for piece in range(n_pieces):  # no branch within, so that lights are worked out abreast
            x, y, t = places[piece, 0], places[piece, 1], pieces[piece, 0]
            lit[piece, 0], lit[piece, 1], lit[piece, 2] = _light(
                x, y, t, corners, triangles, lights
            )
        for column in range(size):
            for c in range(3):
                line[column, c] = ground[c]
        for piece in range(n_pieces):
            for c in range(3):
                line[pieces[piece, 1], c] += shares[piece] * (lit[piece, c] - ground[c])
        for column in range(size):
            for c in range(3):
                light = line[column, c] if line[column, c] > ZERO else ZERO  # nan is dark
                level = min(light, ONE) * np.float32(len(encoded) - 1)
                picture[row, column, c] = encoded[int(level + HALF)]


@numba.njit(cache=True, error_model="numpy")
def _split(upper, lower, row, places, shares, pieces):
    """The pieces of triangles in a row of pixels: where, how much of the pixel, which; how many.

    upper, lower (2 * size,): the owners of the row's samples.
    """
    n_pieces = 0
    owners = np.empty(4, np.int32)
    for column in range(len(upper) // 2):
        owners[0], owners[1] = upper[2 * column], upper[2 * column + 1]
        owners[2], owners[3] = lower[2 * column], lower[2 * column + 1]
        for first in range(4):
            t = owners[first]
            if t < 0:
                continue
            x, y, n = ZERO, ZERO, ZERO
            for sample in range(first, 4):
                if owners[sample] == t:
                    x += np.float32(sample & 1) + ACROSS[sample >> 1]
                    y += np.float32(sample >> 1)
                    n += ONE
                    owners[sample] = -1
            places[n_pieces, 0] = np.float32(2 * column) + x / n
            places[n_pieces, 1] = np.float32(2 * row) + HALF + y / n
            shares[n_pieces] = n * QUARTER
            pieces[n_pieces, 0], pieces[n_pieces, 1] = t, column
            n_pieces += 1
    return n_pieces


@numba.njit(cache=True, error_model="numpy")
def _light(x, y, t, corners, triangles, lights):
    """Linear light that triangle t sends from a place in the picture."""
    i, j, k = triangles[t, 0], triangles[t, 1], triangles[t, 2]
    x2, y2 = corners[k, 0], corners[k, 1]
    ax, ay = corners[i, 0] - x2, corners[i, 1] - y2
    bx, by = corners[j, 0] - x2, corners[j, 1] - y2
    area = ax * by - bx * ay
    dx, dy = x - x2, y - y2
    inverse = ONE / area
    w0 = (dx * by - bx * dy) * inverse
    w1 = (ax * dy - dx * ay) * inverse
    w2 = ONE - w0 - w1
    nx = w0 * corners[i, 2] + w1 * corners[j, 2] + w2 * corners[k, 2]
    ny = w0 * corners[i, 3] + w1 * corners[j, 3] + w2 * corners[k, 3]
    nz = w0 * corners[i, 4] + w1 * corners[j, 4] + w2 * corners[k, 4]
    scale = ONE / np.sqrt(nx * nx + ny * ny + nz * nz + TINY)
    inside = area > ZERO  # rows grow downwards: counter-clockwise has a negative area
    scale = -scale if inside else scale
    nx, ny, nz = nx * scale, ny * scale, nz * scale
    key = nx * lights[0, 0] + ny * lights[0, 1] + nz * lights[0, 2]
    fill = max(nx * lights[2, 0] + ny * lights[2, 1] + nz * lights[2, 2], ZERO)
    sky = HALF + HALF * ny
    ground = ONE - sky
    away = ONE - max(nz, ZERO)
    rim = lights[8, 0] * away * away * away * sky
    sheen = max(nx * lights[7, 0] + ny * lights[7, 1] + nz * lights[7, 2], ZERO)
    for _ in range(SHEEN_SQUARINGS):
        sheen *= sheen
    lamp = nx * lights[10, 0] + ny * lights[10, 1] + nz * lights[10, 2]
    mirror = max(ONE - MIRRORED * (ONE - lamp), ZERO)
    gloss = w0 * corners[i, 8] + w1 * corners[j, 8] + w2 * corners[k, 8]
    gloss *= (ONE - gloss) * sheen + gloss * lights[8, 1] * mirror * mirror
    red = max((key + lights[6, 0]) * lights[9, 0], ZERO) * lights[1, 0]
    green = max((key + lights[6, 1]) * lights[9, 1], ZERO) * lights[1, 1]
    blue = max((key + lights[6, 2]) * lights[9, 2], ZERO) * lights[1, 2]
    red += fill * lights[3, 0] + sky * lights[4, 0] + ground * lights[5, 0] + rim
    green += fill * lights[3, 1] + sky * lights[4, 1] + ground * lights[5, 1] + rim
    blue += fill * lights[3, 2] + sky * lights[4, 2] + ground * lights[5, 2] + rim
    dim = lights[8, 2] if inside else ONE
    gloss = ZERO if inside else gloss
    red *= dim * (w0 * corners[i, 5] + w1 * corners[j, 5] + w2 * corners[k, 5])
    green *= dim * (w0 * corners[i, 6] + w1 * corners[j, 6] + w2 * corners[k, 6])
    blue *= dim * (w0 * corners[i, 7] + w1 * corners[j, 7] + w2 * corners[k, 7])
    return red + gloss, green + gloss, blue + gloss
