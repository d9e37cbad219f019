"""Closed, two-manifold, outward and clean for whatever the samples are: all cell patterns, noise, ties, odd values, thin volumes."""

import numpy as np

from judge import Judge, distinct

judge = Judge("cells")
random = np.random.default_rng(20)


def patterns():
    """All 256 sets of inside corners, each in a cell of its own, as an array (256, 2, 2, 2) of booleans."""
    bits = (np.arange(256)[:, None] >> np.arange(8)) & 1
    return bits.reshape(256, 2, 2, 2).astype(bool)


def packed(blocks, around, pitch=4):
    """Blocks side by side in one volume, kept apart by samples of value `around`."""
    volume = np.full((pitch, 16 * pitch, 16 * pitch), around, blocks.dtype)
    for n, block in enumerate(blocks):
        y, x = (n // 16) * pitch + 1, (n % 16) * pitch + 1
        volume[1:3, y : y + 2, x : x + 2] = block
    return volume


inside = patterns()
for around in (-100, 100):
    for n in range(4):
        high, low = random.integers(1, 1000, inside.shape), random.integers(-1000, 0, inside.shape)
        volume = packed(np.where(inside, high, low).astype(np.int16), around)
        judge.mesh([*judge.raw(volume), "--iso", 0], f"256 cells in {around}, integer values {n}")
        high, low = random.exponential(1, inside.shape), -random.exponential(1, inside.shape) - 1e-9
        volume = packed(np.where(inside, high, low).astype(np.float32), around)
        judge.mesh([*judge.raw(volume), "--iso", 0], f"256 cells in {around}, float values {n}")
# Both sides equally far, so that every decision is a tie; then inside samples that are the iso value itself.
judge.mesh([*judge.raw(packed(np.where(inside, 1, -1).astype(np.int8), -1)), "--iso", 0], "256 cells, all ties")
judge.mesh([*judge.raw(packed(np.where(inside, 0, -1).astype(np.int8), -1)), "--iso", 0], "256 cells at the iso value")
judge.mesh([*judge.raw(packed(np.where(inside, -1, 0).astype(np.int8), 0)), "--iso", 0, "--invert"], "256 cells, inverted")
judge.say("all 256 corner patterns among outside and among inside samples")

for n, dims in enumerate([(20, 20, 20), (7, 9, 63), (5, 6, 64), (6, 5, 65), (4, 3, 128), (9, 40, 31)]):
    volume = random.standard_normal(dims).astype(np.float32)
    judge.mesh([*judge.raw(volume, spacing=(0.7, 1.3, 2.9), origin=(-120, 45, 900)), "--iso", 0.1 * n - 0.3], f"float noise {dims}")
    volume = random.integers(0, 5, dims).astype(np.uint8)
    judge.mesh([*judge.raw(volume), "--iso", 2], f"integer noise with the iso among the samples {dims}")
for kind in ("u1", "i1", "<u2", ">i2", "<u4", ">i4", "<u8", ">i8", "<f4", ">f8"):
    volume = random.integers(0, 100, (9, 10, 11)).astype(kind)
    judge.mesh([*judge.raw(volume), "--iso", 50], f"noise of type {kind}")
sparse = (random.random((30, 30, 30)) < 0.02).astype(np.uint8)
judge.mesh([*judge.raw(sparse), "--iso", 0.5], "lone samples")
judge.mesh([*judge.raw(1 - sparse), "--iso", 0.5], "lone holes")
judge.mesh([*judge.raw(sparse), "--iso", 0.5, "--invert"], "lone samples, inverted")
judge.mesh([*judge.raw(random.standard_normal((12, 12, 12)) * 1e-30), "--iso", 1e-31], "noise of tiny values")
judge.mesh([*judge.raw(random.standard_normal((12, 12, 12)) * 1e300), "--iso", 1e299], "noise of huge values")
volume = np.full((10, 10, 10), -1e9, np.float32)
volume[random.random(volume.shape) < 0.5] = 1e-9
judge.mesh([*judge.raw(volume), "--iso", 0], "noise with every crossing at a sample")
judge.say("noise of floats, of integers with the iso value among them, of every stored type")

z, y, x = np.indices((13, 13, 13))
judge.mesh([*judge.raw(((x + y + z) % 2).astype(np.uint8)), "--iso", 1], "checkerboard at the samples' value")
judge.mesh([*judge.raw(((x + y + z) % 2).astype(np.int16) * 2 - 1), "--iso", 0], "checkerboard, ties")
judge.mesh([*judge.raw(((x // 2 + y // 2 + z // 2) % 2).astype(np.uint8)), "--iso", 0.5], "checkerboard of 2 x 2 x 2")
judge.mesh([*judge.raw(((x + y) % 2).astype(np.uint8)), "--iso", 0.5], "columns")
judge.mesh([*judge.raw((z % 2).astype(np.uint8)), "--iso", 0.5], "sheets")
judge.mesh([*judge.raw(np.minimum(np.maximum(x + y - 12, -2), 2).astype(np.int16)), "--iso", -2], "plateau at the iso value")
judge.mesh([*judge.raw(np.rint(np.sin(x) * np.cos(y) + np.sin(z)).astype(np.float32)), "--iso", 0], "plateaus")
judge.mesh([*judge.raw(np.zeros((5, 6, 7), np.int16)), "--iso", 0], "all inside")
judge.mesh([*judge.raw(np.zeros((5, 6, 7), np.int16)), "--iso", -1.5], "all inside, negative iso")
judge.say("checkerboards, columns, sheets, plateaus, a full volume")

for n in range(4):
    volume = random.standard_normal((11, 12, 13)).astype(np.float32 if n % 2 else np.float64)
    for value in (np.nan, np.inf, -np.inf):
        volume[random.random(volume.shape) < 0.15] = value
    judge.mesh([*judge.raw(volume), "--iso", 0.2], f"NaN and infinities {n}")
    judge.mesh([*judge.raw(volume), "--iso", 0.2, "--invert"], f"NaN and infinities {n}, inverted")
judge.say("NaN and infinities")

for dims in ((1, 1, 1), (1, 1, 9), (1, 9, 1), (9, 1, 1), (1, 12, 13), (12, 1, 13), (12, 13, 1), (1, 2, 64), (2, 2, 2), (1, 3, 65)):
    volume = random.standard_normal(dims)
    volume.flat[0] = 1
    judge.mesh([*judge.raw(volume, spacing=(0.5, 2, 3)), "--iso", 0], f"thin {dims}")
judge.say("volumes of one sample, one row, one plane")

for n in range(3):
    dims = np.array((14, 15, 16))
    centre = random.random(3) * dims
    away = np.linalg.norm(np.indices(dims) - centre[:, None, None, None], axis=0)
    volume = (9 - away).astype(np.float32)
    judge.mesh([*judge.raw(volume), "--iso", 0], f"ball cut by the border {n}")
    judge.mesh([*judge.raw(volume), "--iso", 0, "--invert"], f"hollow cut by the border {n}")
    if n == 0:
        open_mesh = judge.mesh([*judge.raw(volume), "--iso", 0, "--open"], "ball cut by the border, left open", closed=False)
        if open_mesh is not None:
            points, faces = open_mesh
            edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
            rim, index = distinct(edges)
            uses = np.bincount(index)
            ends = points[np.unique(rim[uses == 1])]
            on_border = ((ends == 0) | (ends == dims[::-1] - 1)).any(axis=1)
            judge.expect(len(ends) > 0 and on_border.all(), "with --open, boundary edges lie on the border alone")
judge.say("regions that leave the volume")
judge.finish()
