"""Draws binary PLY meshes side by side as a PNG, with numpy alone: the pictures of the guide.

    python docs/picture.py OUT.png WIDTH HEIGHT AZIMUTH ELEVATION MESH.ply...

Each mesh is seen from a direction given in degrees (azimuth 0 from the front, which is +y; elevation from above) and fills
its part of the picture. Needs numpy.
"""

import struct
import sys
import zlib

import numpy as np

LIGHT = np.array((-0.45, 0.5, 0.74))
SAMPLES = 3


def load(path):
    """Points and triangles of a binary little-endian PLY with x y z first in each vertex."""
    data = open(path, "rb").read()
    end = data.index(b"end_header\n") + 11
    words = [line.split() for line in data[:end].decode("latin-1").splitlines()]
    counts = {w[1]: int(w[2]) for w in words if w[0] == "element"}
    n_float = sum(1 for w in words if w[:2] in (["property", "float"], ["property", "float32"]))
    points = np.frombuffer(data, "<f4", counts["vertex"] * n_float, end).reshape(-1, n_float)[:, :3]
    faces = np.frombuffer(data, np.dtype([("n", "u1"), ("v", "<u4", 3)]), counts["face"], end + points.shape[0] * n_float * 4)
    return points.astype(np.float64), faces["v"].astype(np.int64)


def normals(points, faces):
    """Unit normals at the vertices: the mean of the faces' around them, by area."""
    a, b, c = points[faces].transpose(1, 0, 2)
    across = np.cross(b - a, c - a)
    total = np.stack([np.bincount(faces.ravel(), np.repeat(across[:, n], 3), len(points)) for n in range(3)], axis=1)
    return total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-30)


def draw(path, width, height, azimuth, elevation):
    """Shades from 0 to 1, and how much of each pixel is covered."""
    points, faces = load(path)
    turn, tilt = np.radians(azimuth), np.radians(elevation)
    right = np.array((-np.cos(turn), np.sin(turn), 0.0))
    toward = np.array((np.sin(turn) * np.cos(tilt), np.cos(turn) * np.cos(tilt), np.sin(tilt)))
    frame = np.stack([right, np.cross(toward, right), toward])
    seen, facing = points @ frame.T, normals(points, faces) @ frame.T
    w, h = width * SAMPLES, height * SAMPLES
    low, high = seen[:, :2].min(axis=0), seen[:, :2].max(axis=0)
    scale = 0.94 * min(w / (high[0] - low[0]), h / (high[1] - low[1]))
    seen = (seen - np.append((low + high) / 2, 0)) * scale + (w / 2, h / 2, 0)
    depth, shade = np.full(w * h, -np.inf), np.zeros(w * h)
    light = LIGHT / np.linalg.norm(LIGHT)
    corners = seen[faces]
    size = np.ceil((corners[:, :, :2].max(axis=1) - corners[:, :, :2].min(axis=1)).max(axis=1)).astype(int) + 1
    # Points close enough together that no pixel of a triangle is missed, for triangles of like size at once.
    for n in np.unique(size):
        u, v = np.meshgrid(np.arange(n + 1) / n, np.arange(n + 1) / n, indexing="ij")
        weights = np.stack([u, v, 1 - u - v], axis=-1)[u + v <= 1 + 1e-9]
        chosen = np.flatnonzero(size == n)
        for some in np.array_split(chosen, len(chosen) * len(weights) // 2_000_000 + 1):
            x, y, z = np.einsum("wc,fcd->dfw", weights, corners[some]).reshape(3, -1)
            normal = np.einsum("wc,fcd->fwd", weights, facing[faces[some]]).reshape(-1, 3)
            value = 0.16 + 0.84 * np.clip(normal @ light, 0, 1) / np.maximum(np.linalg.norm(normal, axis=1), 1e-30)
            pixel = y.astype(int).clip(0, h - 1) * w + x.astype(int).clip(0, w - 1)
            order = np.lexsort((z, pixel))
            last = order[np.append(pixel[order][1:] != pixel[order][:-1], True)]
            nearer = last[z[last] > depth[pixel[last]]]
            depth[pixel[nearer]], shade[pixel[nearer]] = z[nearer], value[nearer]
    blocks = lambda a: a.reshape(h, w)[::-1].reshape(height, SAMPLES, width, SAMPLES).mean(axis=(1, 3))
    return blocks(np.where(np.isfinite(depth), shade, 0)), blocks(np.isfinite(depth).astype(float))


def main():
    out, width, height, azimuth, elevation = sys.argv[1], *map(int, sys.argv[2:4]), *map(float, sys.argv[4:6])
    parts = [draw(path, width, height, azimuth, elevation) for path in sys.argv[6:]]
    shade, cover = (np.concatenate([part[n] for part in parts], axis=1) for n in (0, 1))
    # One byte a pixel: 51 shades of bone by 5 of cover, mixed with white by the palette, keep the file small.
    index = np.round(50 * shade / np.maximum(cover, 1e-9)) * 5 + np.round(4 * cover)
    shades, covers = np.arange(255)[:, None] // 5 / 50, np.arange(255)[:, None] % 5 / 4
    palette = np.round(255 * (covers * shades * (0.97, 0.93, 0.85) + 1 - covers)).astype(np.uint8)
    index = np.where(np.round(4 * cover) == 0, 0, index).astype(np.uint8)
    rows = b"".join(b"\0" + row.tobytes() for row in index)
    chunk = lambda kind, data: struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    size = struct.pack(">IIBBBBB", index.shape[1], index.shape[0], 8, 3, 0, 0, 0)
    with open(out, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", size) + chunk(b"PLTE", palette.tobytes()) + chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b""))


main()
