"""--method tetrahedra: as closed, manifold and clean as cubes; vertices and Euler number of the linear interpolant in Kuhn's split."""

import itertools

import numpy as np
from scipy.spatial import cKDTree

from judge import Judge, area_volume, euler

judge = Judge("tetrahedra")
random = np.random.default_rng(21)
STEPS = [step for step in itertools.product((0, 1), repeat=3) if any(step)]  # z, y, x


def tetrahedra(volume, iso, what, *options, closed=True, **raw):
    return judge.mesh([*judge.raw(volume, **raw), "--iso", iso, "--method", "tetrahedra", *options], what, closed=closed)


def shifted(volume, step):
    """The volume's samples at the lower and at the upper ends of all its edges along a step."""
    low = tuple(slice(0, n - d) for n, d in zip(volume.shape, step))
    high = tuple(slice(d, n) for n, d in zip(volume.shape, step))
    return volume[low], volume[high]


def crossings(samples, iso):
    """Where linear interpolation meets the iso value on the seven kinds of edges; a layer of outside lies around the volume."""
    values = np.pad(samples.astype(np.float64), 1, constant_values=-np.inf)
    found = []
    for step in STEPS:
        low, high = shifted(values, step)
        index = np.argwhere((low >= iso) != (high >= iso))
        a, b = low[tuple(index.T)], high[tuple(index.T)]
        with np.errstate(invalid="ignore"):
            t = (iso - a) / (b - a)
        t = np.where(np.isneginf(a), 1, np.where(np.isneginf(b), 0, t)).clip(2**-10, 1 - 2**-10)
        found.append(index - 1 + t[:, None] * step)
    return np.concatenate(found)[:, ::-1]


def inside_euler(inside):
    """Of the samples inside with the edges, triangles and tetrahedra of the split between them."""
    inside = np.pad(inside, 1)
    number = int(inside.sum())
    chains = [chain for n in (1, 2, 3) for chain in itertools.combinations(STEPS, n)]
    for chain in chains:
        if all(all(a <= b for a, b in zip(*pair)) for pair in itertools.combinations(sorted(chain, key=sum), 2)):
            all_in = inside[:-1, :-1, :-1].copy()
            for step in chain:
                all_in &= inside[tuple(slice(d, n - 1 + d) for n, d in zip(inside.shape, step))]
            number += (-1) ** len(chain) * int(all_in.sum())
    return number


bits = ((np.arange(256)[:, None] >> np.arange(8)) & 1).reshape(256, 2, 2, 2).astype(bool)
for around in (-100, 100):
    volume = np.full((4, 64, 64), around, np.int16)
    for n, block in enumerate(bits):
        y, x = (n // 16) * 4 + 1, (n % 16) * 4 + 1
        volume[1:3, y : y + 2, x : x + 2] = np.where(block, random.integers(0, 1000, block.shape), random.integers(-1000, 0, block.shape))
    tetrahedra(volume, 0, f"256 cells in {around}")
    tetrahedra(volume, 0, f"256 cells in {around}, inverted", "--invert")
judge.say("all 256 corner patterns")

for n, dims in enumerate([(20, 20, 20), (7, 9, 63), (5, 6, 64), (6, 5, 65), (1, 1, 1), (1, 9, 1), (1, 12, 13), (12, 13, 1)]):
    volume = random.integers(-2, 3, dims).astype(np.int8)
    volume.flat[0] = 1
    tetrahedra(volume, 0, f"integers with the iso among them {dims}", spacing=(0.7, 1.3, 2.9), origin=(-120, 45, 900))
    volume = random.standard_normal(dims)
    volume.flat[0] = 1
    tetrahedra(volume, 0, f"noise {dims}")
    for value in (np.nan, np.inf, -np.inf):
        volume[random.random(dims) < 0.1] = value
    volume.flat[0] = 1
    tetrahedra(volume, 0, f"NaN and infinities {dims}")
z, y, x = np.indices((9, 9, 9))
tetrahedra(((x + y + z) % 2).astype(np.uint8), 1, "checkerboard")
tetrahedra(np.zeros((3, 4, 5), np.uint8), 0, "all inside")
ball = 9 - np.linalg.norm(np.indices((14, 15, 16)) - np.array((3, 7, 12))[:, None, None, None], axis=0)
tetrahedra(ball, 0, "ball cut by the border, left open", "--open", closed=False)
judge.say("noise, ties, NaN and infinities, thin volumes, checkerboards, a full volume, an open one")

for n in range(3):
    volume = random.standard_normal((11, 12, 13)).astype(np.float32)
    result = tetrahedra(volume, 0.1, f"noise {n}", "--space", "voxel")
    if result is not None:
        points, faces = result
        wanted = crossings(volume, np.float64(0.1))
        judge.expect(len(points) == len(wanted), f"noise {n}: {len(points)} vertices, expected {len(wanted)}")
        judge.near(cKDTree(wanted).query(points)[0].max(), 0, 1e-5, f"noise {n}: vertices on the edges of the split")
        number = 2 * inside_euler(volume.astype(np.float64) >= 0.1)
        judge.expect(euler(points, faces) == number, f"noise {n}: Euler number {euler(points, faces)}, expected {number}")
judge.say("vertices and Euler numbers of the linear interpolant")

errors = []
for step in (1.0, 0.5):
    dims = int(24 / step)
    away = np.linalg.norm((np.indices((dims,) * 3) - (dims - 1) / 2 + 0.137) * step, axis=0)
    result = tetrahedra(10 - away, 0, f"sphere, step {step}", spacing=(step,) * 3)
    if result is not None:
        area, volume = area_volume(*result)
        errors.append(abs(volume / (4 / 3 * np.pi * 1000) - 1))
        judge.near(area, 400 * np.pi, 400 * np.pi * 9 / 800 * step**2, f"sphere, step {step}: area")
        judge.near(errors[-1], 0, 9 / 800 * step**2, f"sphere, step {step}: relative error of the volume")
        judge.expect(euler(*result) == 2, f"sphere, step {step}: Euler number {euler(*result)}")
if len(errors) == 2:
    judge.expect(3 <= errors[0] / errors[1] <= 5, f"sphere: half the step gives {errors[0] / errors[1]:.2f} times less error, expected about 4")
    judge.say(f"sphere: relative error of the volume {errors[0]:.2e}, at half the step {errors[1]:.2e}")
judge.finish()
