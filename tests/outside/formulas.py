"""Spheres, ellipsoids with unequal spacing and tori: area, volume and Euler number of the formula; finer grids come closer."""

import numpy as np
from scipy.special import ellipeinc, ellipkinc

from judge import Judge, area_volume, euler

judge = Judge("formulas")


def millimetres(dims, spacing):
    """Positions x, y, z of the samples of a volume centred near 0, and its origin."""
    origin = [-(n - 1) / 2 * s + 0.137 * s for n, s in zip(dims, spacing)]
    z, y, x = np.meshgrid(*[origin[a] + spacing[a] * np.arange(dims[a]) for a in (2, 1, 0)], indexing="ij")
    return x, y, z, origin


def ellipsoid_area(a, b, c):
    """Exact area for a >= b >= c (Legendre's form)."""
    if a == c:
        return 4 * np.pi * a * a
    phi = np.arccos(c / a)
    m = (a * a * (b * b - c * c)) / (b * b * (a * a - c * c))
    return 2 * np.pi * c * c + 2 * np.pi * a * b / np.sin(phi) * (ellipeinc(phi, m) * np.sin(phi) ** 2 + ellipkinc(phi, m) * np.cos(phi) ** 2)


def shape(what, distance, dims, spacing, area, volume, number, error):
    """One solid `distance >= 0`, held against its formulas within a relative error. Returns the relative volume error."""
    x, y, z, origin = millimetres(dims, spacing)
    samples = distance(x, y, z).astype(np.float64)
    result = judge.mesh([*judge.raw(samples, spacing, origin), "--iso", 0], what)
    if result is None:
        return None
    found_area, found_volume = area_volume(*result)
    judge.near(found_area, area, error * area, f"{what}: area, mm2")
    judge.near(found_volume, volume, error * volume, f"{what}: volume, mm3")
    judge.expect(euler(*result) == number, f"{what}: Euler number {euler(*result)}, expected {number}")
    judge.say(f"{what}: area {found_area / area - 1:+.2e}, volume {found_volume / volume - 1:+.2e}, Euler number {euler(*result)}")
    return abs(found_volume / volume - 1)


def order(what, coarse, fine):
    """Linear interpolation on a grid of half the step has a quarter of the error."""
    if coarse is not None and fine is not None:
        judge.expect(3 <= coarse / fine <= 5, f"{what}: half the step gives {coarse / fine:.2f} times less error, expected about 4")


# A triangle inside a cell has edges of at most sqrt(3) steps, so it lies at most 3 s^2 / (8 r) below the sphere.
r = 10.0
ball = lambda x, y, z: r - np.sqrt(x * x + y * y + z * z)
errors = [
    shape(f"sphere, step {s}", ball, [int(24 / s)] * 3, [s] * 3, 4 * np.pi * r**2, 4 / 3 * np.pi * r**3, 2, 9 / 8 * (s / r) ** 2)
    for s in (1.0, 0.5)
]
order("sphere", *errors)

a, b, c = 21.0, 14.0, 9.0
solid = lambda x, y, z: 1 - np.sqrt((x / a) ** 2 + (y / b) ** 2 + (z / c) ** 2)
errors = [
    shape(
        f"ellipsoid, steps {0.6 * s:g} x {0.9 * s:g} x {1.7 * s:g}", solid, [int(48 / 0.6 / s), int(34 / 0.9 / s), int(24 / 1.7 / s)],
        [0.6 * s, 0.9 * s, 1.7 * s], ellipsoid_area(a, b, c), 4 / 3 * np.pi * a * b * c, 2, 0.012 * s * s,
    )
    for s in (1.0, 0.5)
]
order("ellipsoid", *errors)

big, small = 12.0, 5.0
ring = lambda x, y, z: small - np.sqrt((np.sqrt(x * x + y * y) - big) ** 2 + z * z)
errors = [
    shape(
        f"torus, step {s}", ring, [int(38 / s), int(38 / s), int(14 / s)], [s] * 3, 4 * np.pi**2 * big * small, 2 * np.pi**2 * big * small**2, 0,
        0.016 * s * s,
    )
    for s in (1.0, 0.5)
]
order("torus", *errors)

twice = lambda x, y, z: np.maximum(4 - np.sqrt((x - 6) ** 2 + y * y + z * z), 4 - np.sqrt((x + 6) ** 2 + y * y + z * z))
shape("two spheres", twice, [50, 24, 24], [0.5] * 3, 2 * 4 * np.pi * 16, 2 * 4 / 3 * np.pi * 64, 4, 0.01)
shell = lambda x, y, z: 2 - np.abs(np.sqrt(x * x + y * y + z * z) - 8)
shape("hollow sphere", shell, [46] * 3, [0.5] * 3, 4 * np.pi * (100 + 36), 4 / 3 * np.pi * (1000 - 216), 4, 0.01)
judge.finish()
