"""The volumes that are compared on: made once, by numpy, with a fixed seed."""

import gzip
import os
import shutil
from collections import namedtuple
from pathlib import Path

import nibabel
import numpy as np

WORK = Path(os.environ.get("CARGO_TARGET_DIR", Path(__file__).resolve().parents[2] / "target")) / "peers"
Volume = namedtuple("Volume", "fill iso")


def head(n):
    """A head as a CT sees it: skin, skull, sinuses, with noise; 1.6 M triangles at 512^3."""
    x, y, z = (a / 0.76 for a in np.ogrid[-1 : 1 : n * 1j, -1 : 1 : n * 1j, -1 : 1 : n * 1j][::-1])
    r = np.sqrt((x / 0.72) ** 2 + (y / 0.88) ** 2 + (z / 0.85) ** 2).astype(np.float32)
    v = np.full((n, n, n), -1000, np.float32)
    v[r < 1] = 40
    v[(r > 0.86) & (r < 0.94)] = 900
    for centre, radius, value in [((0.25, -0.5, 0.1), 0.12, -900), ((-0.25, -0.5, 0.1), 0.12, -900), ((0, 0.2, -0.3), 0.18, 700)]:
        v[sum((a - c) ** 2 for a, c in zip((x, y, z), centre)) < radius**2] = value
    for axis in range(3):
        v = (np.roll(v, 1, axis) + 2 * v + np.roll(v, -1, axis)) / 4
    return v + np.random.default_rng(1).normal(0, 35, v.shape).astype(np.float32)


def gyroid(n, period):
    """A gyroid with a period of so many voxels: as dense at any size."""
    a = np.arange(n, dtype=np.float32) * (2 * np.pi / period)
    x, y, z = a[None, None, :], a[None, :, None], a[:, None, None]
    return 1000 * (np.sin(x) * np.cos(y) + np.sin(y) * np.cos(z) + np.sin(z) * np.cos(x))


def empty(n):
    """Air, with one small block."""
    v = np.full((n, n, n), -1000, np.int16)
    v[n // 2 - 3 : n // 2 + 3, n // 2 - 3 : n // 2 + 3, n // 2 - 3 : n // 2 + 3] = 1000
    return v


VOLUMES = {
    "ct-i16": Volume(lambda n: head(n).astype(np.int16), 300),
    "gyroid-120-i16": Volume(lambda n: gyroid(n, 120).astype(np.int16), 0),
    "gyroid-56-i16": Volume(lambda n: gyroid(n, 56).astype(np.int16), 0),
    "empty-i16": Volume(empty, 300),
    "ct-u8": Volume(lambda n: np.clip((head(n) + 1000) / 8, 0, 255).astype(np.uint8), 162),
    "ct-f32": Volume(head, 300),
}


def make(name, n, end):
    """The path of a volume, made if it is not there."""
    path = WORK / f"{name}-{n}{end}"
    if path.exists():
        return path
    part = WORK / f"part-{name}-{n}{end}"
    if name == "balls":
        balls(part, n)
    elif end == ".npy":
        np.save(part, VOLUMES[name].fill(n))
    elif end == ".nii":
        samples = np.load(make(name, n, ".npy"), mmap_mode="r")
        image = nibabel.Nifti1Image(samples.transpose(2, 1, 0), np.diag([0.5, 0.5, 0.5, 1]))
        image.header.set_slope_inter(1, 0)
        nibabel.save(image, part)
    elif end == ".nii.gz":
        with open(make(name, n, ".nii"), "rb") as source, gzip.open(part, "wb", 6) as target:
            shutil.copyfileobj(source, target, 1 << 20)
    part.rename(path)
    return path


def balls(path, n):
    """A sparse file of int16 with a few balls of 1000 in it, by the planes that they touch."""
    with open(path, "wb") as file:
        file.truncate(2 * n**3)
        a = np.arange(n)
        for centre, radius in [((n // 2, n // 2, n // 2), n // 8), ((n // 4, n // 3, n // 5), n // 16)]:
            for k in range(centre[2] - radius, centre[2] + radius + 1):
                across = (a[None, :] - centre[0]) ** 2 + (a[:, None] - centre[1]) ** 2 + (k - centre[2]) ** 2
                file.seek(2 * n * n * k)
                file.write((1000 * (across < radius**2)).astype("<i2").tobytes())
