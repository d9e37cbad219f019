"""Normals: on spheres against the formula, on the CT head against numpy's gradient and trimesh's normals of its faces."""

import nibabel
import numpy as np
import trimesh
from scipy.ndimage import map_coordinates

from judge import ROOT, Judge

judge = Judge("normals")


def with_normals(arguments, kind, what):
    """Points, faces and normals of one surface as trimesh reads them, or None."""
    path = judge.folder / f"mesh.{kind.split()[0]}"
    path.unlink(missing_ok=True)
    if not judge.run([*arguments, "--normals", *kind.split()[1:]], path, f"{what} as {kind}"):
        return None
    mesh = trimesh.load(path, process=False, **({"maintain_order": True} if path.suffix == ".obj" else {}))
    judge.meshes += 1
    judge.triangles += len(mesh.faces)
    stored = "vertex_normals" in mesh._cache
    judge.expect(stored, f"{what} as {kind}: trimesh finds normals in the file")
    points, normals = np.asarray(mesh.vertices, np.float64), np.asarray(mesh.vertex_normals, np.float64)
    judge.expect(len(points) == len(normals) > 0, f"{what} as {kind}: a normal for each vertex")
    judge.near(np.abs(np.linalg.norm(normals, axis=1) - 1).max(), 0, 1e-6, f"{what} as {kind}: length 1")
    return points, np.asarray(mesh.faces), normals


def degrees(a, b):
    """Angles between rows."""
    a, b = (v / np.linalg.norm(v, axis=1)[:, None] for v in (a, b))
    return np.degrees(2 * np.arcsin(np.minimum(np.linalg.norm(a - b, axis=1) / 2, 1)))


radius, worst = 20.0, []
for step in (1.0, 0.5):
    spacing = np.array([0.5, 0.7, 2.0]) * step
    dims = (48 / spacing).astype(int)
    origin = -(dims - 1) / 2 * spacing + 0.137 * spacing
    z, y, x = np.meshgrid(*[origin[a] + spacing[a] * np.arange(dims[a]) for a in (2, 1, 0)], indexing="ij")
    samples = (1000 / np.sqrt(x * x + y * y + z * z)).astype(np.float32)
    found = with_normals([*judge.raw(samples, spacing, origin), "--iso", 1000 / radius], "ply", f"sphere, step {step}")
    if found is not None:
        worst.append(degrees(found[2], found[0]).max())
        # The field is 1 / r: its central differences are off by (h / r)^2, their interpolation by 6 / 8 of that.
        judge.near(worst[-1], 0, np.degrees(1.75 * (spacing[2] / radius) ** 2), f"sphere, spacing {spacing}: degrees off the formula")
if len(worst) == 2:
    judge.say(f"sphere of 20 mm at 0.5 x 0.7 x 2.0 mm: {worst[0]:.3f} degrees off at most, at half of that {worst[1]:.3f}")
    judge.expect(3 <= worst[0] / worst[1] <= 5, f"sphere: half the step gives {worst[0] / worst[1]:.2f} times less, expected about 4")

path = ROOT / "testdata" / "ct_head.nii.gz"
image = nibabel.load(path)
samples = np.asanyarray(image.dataobj).astype(np.float64)
result = with_normals([path, "--iso", 300], "ply", "CT head")
if result is not None:
    points, faces, normals = result
    index = nibabel.affines.apply_affine(np.linalg.inv(image.affine), points)
    # Vertices on grid edges away from the border; those inside cells have no whole index, those on the cap lie outside.
    whole = np.abs(index - np.round(index)) < 1e-3
    on_edge = whole.sum(axis=1) >= 2
    inner = (index > 0.01).all(axis=1) & (index < np.array(samples.shape) - 1.01).all(axis=1)
    gradient = np.stack([map_coordinates(g, index.T, order=1) for g in np.gradient(samples)], axis=1)
    numpy_normals = -gradient @ np.linalg.inv(image.affine[:3, :3])
    usable = on_edge & inner & (np.linalg.norm(numpy_normals, axis=1) > 0)
    off = degrees(normals[usable], numpy_normals[usable])
    # Where the gradient points against its own edge the normal takes the edge's rise instead.
    same = np.mean(off < 0.05)
    judge.expect(same > 0.97, f"CT head: {100 * same:.2f} % of the normals are those of numpy's gradient, expected 97 %")
    judge.say(f"CT head at 300: numpy's gradient at {100 * same:.2f} % of {usable.sum()} vertices on grid edges, median {np.median(off):.1e} degrees")

    mesh = trimesh.Trimesh(points, faces, process=False, validate=False)
    corner = points[faces]
    cross = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    by_area = np.zeros_like(points)
    for k in range(3):
        np.add.at(by_area, faces[:, k], cross)
    for name, other in (("area-weighted", by_area), ("trimesh's", np.asarray(mesh.vertex_normals))):
        there = np.linalg.norm(other, axis=1) > 0
        off = degrees(normals[there], other[there])
        judge.say(f"CT head: to the {name} normals of the faces {np.median(off):.2f} degrees in the median, {np.percentile(off, 95):.1f} for 95 %")
        judge.near(np.median(off), 0, 8, f"CT head: median angle to the {name} normals of the faces")
        judge.expect(np.mean(off < 90) > 0.99, f"CT head: {100 * np.mean(off < 90):.2f} % of the normals leave the faces outward")
    for kind in ("obj", "ply --ascii"):
        again = with_normals([path, "--iso", 300], kind, "CT head")
        if again is not None:
            same = np.array_equal(again[2].astype(np.float32), normals.astype(np.float32)) and np.array_equal(again[1], faces)
            judge.expect(same, f"CT head as {kind}: the same normals, to the bit, as binary PLY")
judge.finish()
