"""Scans: the CT head of testdata against nibabel and scipy, and DICOM series against SimpleITK."""

import os
from pathlib import Path

import nibabel
import numpy as np
import SimpleITK
from scipy.spatial import cKDTree

from judge import ROOT, Judge, area_volume, euler

judge = Judge("scans")
ISO = 300


def crossings(samples, iso):
    """Points, in sample units, where linear interpolation meets the iso value on each grid edge whose ends differ.

    Each lies at least 2^-10 of a step from both ends. A layer of outside lies around the volume.
    """
    found = []
    values = np.pad(samples.astype(np.float64), 1, constant_values=-np.inf)
    for axis in range(3):
        low, high = np.take(values, range(values.shape[axis] - 1), axis), np.take(values, range(1, values.shape[axis]), axis)
        index = np.argwhere((low >= iso) != (high >= iso))
        a, b = low[tuple(index.T)], high[tuple(index.T)]
        with np.errstate(invalid="ignore"):
            t = (iso - a) / (b - a)
        t = np.where(np.isneginf(a), 1, np.where(np.isneginf(b), 0, t)).clip(2**-10, 1 - 2**-10)
        points = index.astype(np.float64) - 1
        points[:, axis] += t
        found.append(points)
    return np.concatenate(found)


path = ROOT / "testdata" / "ct_head.nii.gz"
image = nibabel.load(path)
samples = np.asanyarray(image.dataobj)
result = judge.mesh([path, "--iso", ISO], "CT head")
if result is not None:
    points, faces = result
    wanted = nibabel.affines.apply_affine(image.affine, crossings(samples, ISO))
    away, nearest = cKDTree(points).query(wanted)
    judge.near(away.max(), 0, 1e-4, "CT head: a vertex at every crossing that nibabel's affine and linear interpolation give, mm")
    extra = len(points) - len(wanted)
    judge.expect(len(np.unique(nearest)) == len(wanted), "CT head: one vertex for each crossing")
    judge.expect(0 <= extra <= 0.01 * len(points), f"CT head: {extra} vertices beyond the crossings, for tunnels and cell faces")
    area, volume = area_volume(points, faces)
    box = np.abs(np.linalg.det(image.affine[:3, :3])) * np.count_nonzero(samples >= ISO)
    judge.expect(0.8 * box < volume < 1.2 * box, f"CT head: encloses {volume:.0f} mm3, the samples inside have {box:.0f}")
    judge.say(f"CT head at {ISO}: {len(points)} vertices ({extra} beyond the crossings), {len(faces)} triangles, Euler number {euler(points, faces)}")
    judge.say(f"furthest from nibabel and linear interpolation: {away.max():.2e} mm; {area:.0f} mm2, {volume:.0f} mm3")
for iso in (-200.5, 1000):
    judge.mesh([path, "--iso", iso], f"CT head at {iso}")

for kind, more in (("ply", ()), ("stl", ()), ("obj", ()), ("ply", ("--ascii",)), ("stl", ("--ascii",))):
    meshes = []
    for threads in (1, 2, 7) if not more else (2,):
        out = judge.folder / f"threads.{kind}"
        if judge.run([path, "--iso", ISO, "--threads", threads, *more], out, f"CT head on {threads} threads as {kind}"):
            meshes.append(out.read_bytes())
    if not more:
        judge.expect(len(meshes) == 3 and len(set(meshes)) == 1, f"CT head as {kind}: the same bytes for 1, 2 and 7 threads")
    if (kind, more) in (("obj", ()), ("ply", ("--ascii",))) and result is not None and meshes:
        found = judge.look(out, f"CT head as {kind} {' '.join(more)}")
        same = len(found[0]) == len(result[0]) and np.array_equal(found[0].astype(np.float32), result[0].astype(np.float32))
        judge.expect(same, f"CT head as {kind} {' '.join(more)}: the same vertices, to the bit, as binary PLY")
judge.say("the same bytes for 1, 2 and 7 threads; text holds the same numbers")

studies = [ROOT / "testdata" / "dicom" / name for name in ("good-series", "mr-anisotropic-rescale")]
# The whole collection of scans, of which testdata has the small ones; testdata/README.md has more on it.
if "MCUBES_SCANS" in os.environ:
    studies += [Path(os.environ["MCUBES_SCANS"]) / "dicom" / "real" / name for name in ("philips-head-3mm", "philips-tilt-minus18")]
for folder in studies:
    if not judge.expect(folder.is_dir(), f"DICOM {folder.name}: {folder} is there"):
        continue
    reader = SimpleITK.ImageSeriesReader()
    series = [reader.GetGDCMSeriesFileNames(str(folder), s) for s in reader.GetGDCMSeriesIDs(str(folder))]
    reader.SetFileNames(max(series, key=len))
    image = reader.Execute()
    values = SimpleITK.GetArrayViewFromImage(image)
    iso = float(values.min() + 0.4 * (float(values.max()) - float(values.min())))
    mesh = judge.mesh([folder, "--iso", iso], f"DICOM {folder.name}")
    if mesh is None:
        continue
    size = np.array(image.GetSize()) - 1
    corners = [image.TransformContinuousIndexToPhysicalPoint([float(c) for c in size * k]) for k in np.ndindex(2, 2, 2)]
    corners = np.array(corners) * (-1, -1, 1)
    lower, upper, slack = corners.min(axis=0), corners.max(axis=0), 0.02 * max(image.GetSpacing())
    low, high = mesh[0].min(axis=0), mesh[0].max(axis=0)
    inside = (low >= lower - slack).all() and (high <= upper + slack).all()
    judge.expect(inside, f"DICOM {folder.name}: {low} to {high} lies in SimpleITK's {lower} to {upper}")
    judge.say(f"DICOM {folder.name}: {len(values)} slices at {iso:g}, {len(mesh[1])} triangles, inside SimpleITK's bounds")
judge.finish()
