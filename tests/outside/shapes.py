"""Phantoms against their formulas, and crop, blur and downsample against nibabel, scipy and numpy."""

import json
import subprocess
import time

import nibabel
import numpy as np
import SimpleITK
import trimesh
from nibabel.affines import apply_affine
from scipy.ndimage import gaussian_filter
from scipy.spatial import cKDTree
from scipy.special import ellipeinc, ellipkinc

from judge import MCUBES, ROOT, Judge, area_volume, euler

judge = Judge("shapes")


# Phantoms: what is printed, what nibabel reads, what the mesh has, what the formula says.

def phantom(kind, name, *flags):
    """Writes a phantom; returns its path and what was printed of it."""
    path = judge.folder / name
    command = [MCUBES, "phantom", kind, "-o", path, "-q", "--json", *map(str, flags)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    if not judge.expect(done.returncode == 0, f"phantom {kind}: exit status {done.returncode}: {done.stderr.strip()}"):
        return path, None
    return path, json.loads(done.stdout)


DIMS, STEPS = (56, 68, 44), (0.5, 0.7, 0.9)
EXTENT = [(n - 1) * s for n, s in zip(DIMS, STEPS)]
HALF = [e / 2 for e in EXTENT]
AFFINE = nibabel.affines.from_matvec(np.diag(STEPS), [-h for h in HALF])
SIZE = ("--dims", "x".join(map(str, DIMS)), "--spacing", "x".join(map(str, STEPS)))


def formula(kind):
    """Area, volume and Euler number, after what docs/guide.md says of the shapes' sizes; what no formula gives is None."""
    if kind == "sphere":
        r = 0.8 * min(HALF)
        return 4 * np.pi * r**2, 4 / 3 * np.pi * r**3, 2
    if kind == "ellipsoid":
        a, b, c = sorted((0.8 * h for h in HALF), reverse=True)
        phi, m = np.arccos(c / a), (a * a * (b * b - c * c)) / (b * b * (a * a - c * c))
        area = 2 * np.pi * c * c + 2 * np.pi * a * b / np.sin(phi) * (ellipeinc(phi, m) * np.sin(phi) ** 2 + ellipkinc(phi, m) * np.cos(phi) ** 2)
        return area, 4 / 3 * np.pi * a * b * c, 2
    if kind == "torus":
        flat = min(HALF[:2])
        tube = min(0.3 * flat, 0.8 * HALF[2])
        ring = 0.85 * flat - tube
        return 4 * np.pi**2 * ring * tube, 2 * np.pi**2 * ring * tube**2, 0
    if kind == "gyroid":
        return None, np.prod(EXTENT) / 2, None
    return None, None, None


for kind, name, flags in (
    ("sphere", "a.nii.gz", ()), ("sphere", "a.nii", ("--type", "f64")), ("ellipsoid", "b.nii", ("--type", "u8")), ("torus", "c.nii.gz", ("--type", "f32")),
    ("torus", "d.nii", ("--type", "u16")), ("gyroid", "e.nii.gz", ("--type", "f32")), ("metaballs", "f.nii.gz", ()), ("skull-like", "g.nii.gz", ("--type", "i8")),
):
    what = f"phantom {kind} {' '.join(flags)}"
    path, printed = phantom(kind, name, *SIZE, *flags)
    if printed is None:
        continue
    area, volume, number = formula(kind)
    for key, wanted in (("area", area), ("volume", volume), ("euler", number)):
        if wanted is None:
            judge.expect(printed[key] is None, f"{what}: prints no {key}")
        else:
            judge.near(printed[key], wanted, 1e-8 * abs(wanted), f"{what}: prints the formula's {key}")
    image = nibabel.load(path)
    judge.expect(image.shape == DIMS and np.allclose(image.affine, AFFINE, atol=1e-5), f"{what}: nibabel reads {image.shape} {image.affine}")
    judge.expect(nibabel.aff2axcodes(image.affine) == ("R", "A", "S") and image.header.get_xyzt_units()[0] == "mm", f"{what}: RAS, millimetres")
    if kind == "sphere":
        x, y, z = np.meshgrid(*(np.arange(n) * s - h for n, s, h in zip(DIMS, STEPS, HALF)), indexing="ij")
        field = np.clip(500 + (0.8 * min(HALF) - np.sqrt(x * x + y * y + z * z)) / max(STEPS) * 100, 0, 1000)
        away = np.abs(image.get_fdata() - field).max()
        judge.near(away, 0, 1e-6 if flags else 0.5 + 1e-6, f"{what}: nibabel's samples are the formula's")
    result = judge.mesh([path, "--iso", printed["iso"]], what)
    if result is not None and volume is not None:
        found_area, found_volume = area_volume(*result)
        # The greatest step is 0.9 mm, the least radius of curvature about 5 mm; 8 bits round by 2 of the 100 that a step makes.
        judge.near(found_volume, printed["volume"], 0.01 * volume, f"{what}: volume of the mesh, mm3")
        if area is not None:
            judge.near(found_area, printed["area"], 0.01 * area, f"{what}: area of the mesh, mm2")
            judge.expect(euler(*result) == printed["euler"], f"{what}: Euler number {euler(*result)}, printed {printed['euler']}")

clean = nibabel.load(judge.folder / "g.nii.gz").get_fdata()
noisy = [phantom("skull", f"n{n}.nii.gz", *SIZE, "--type", "f32", "--noise", 25, "--seed", seed)[0] for n, seed in enumerate((5, 5, 6))]
plain = nibabel.load(phantom("skull", "plain.nii", *SIZE, "--type", "f32")[0]).get_fdata()
noise = [nibabel.load(path).get_fdata() - plain for path in noisy]
judge.expect(np.abs(clean - plain).max() <= 8, "skull in 8 bits: within half a step of 16 of the skull in floats")
judge.near(noise[0].std(), 25, 0.2, "noise: its deviation")
judge.near(noise[0].mean(), 0, 0.2, "noise: its mean")
judge.expect(noisy[0].read_bytes() == noisy[1].read_bytes() and not np.array_equal(noise[0], noise[2]), "noise: the seed's, and no other")
neighbours = np.corrcoef(noise[0][:-1].ravel(), noise[0][1:].ravel())[0, 1]
judge.near(neighbours, 0, 0.01, "noise: neighbours know nothing of each other")
judge.say("phantoms: printed numbers, nibabel's samples and the meshes agree with the formulas")


# Steps: a mesh of the volume with a step is the mesh of the volume to which numpy or scipy did it.

def save(samples, affine, name):
    path = judge.folder / name
    image = nibabel.Nifti1Image(samples, affine)
    nibabel.save(image, path)
    return path


def other(arguments, what):
    """The mesh of what another program made, to hold a judged one against: points and triangles."""
    path = judge.folder / "other.ply"
    path.unlink(missing_ok=True)
    if not judge.run(arguments, path, what):
        return None
    mesh = trimesh.load(path, process=False, force="mesh")
    return np.asarray(mesh.vertices, np.float64), np.asarray(mesh.faces)


def same(found, wanted, what, tolerance=2e-4):
    """The same triangles, and vertices as near as single precision of the files' affines allows, mm."""
    if found is None or wanted is None:
        return
    if judge.expect(len(found[0]) == len(wanted[0]) and np.array_equal(found[1], wanted[1]), f"{what}: the same triangles, {len(found[1])} and {len(wanted[1])}"):
        judge.near(np.abs(found[0] - wanted[0]).max(), 0, tolerance, f"{what}: furthest vertex, mm")


def means(samples, block):
    """Means of blocks; a short last one of what it has; NaN left out."""
    block = [min(b, n) for b, n in zip(block, samples.shape)]
    padded = np.pad(samples.astype(np.float64), [(0, -n % b) for n, b in zip(samples.shape, block)], constant_values=np.nan)
    count = [n // b for n, b in zip(padded.shape, block)]
    parts = padded.reshape(count[0], block[0], count[1], block[1], count[2], block[2])
    with np.errstate(invalid="ignore"):
        return np.nansum(parts, axis=(1, 3, 5)) / np.isfinite(parts).sum(axis=(1, 3, 5))


def centred(affine, block, shape):
    """The affine of the blocks' centres."""
    block = [min(b, n) for b, n in zip(block, shape)]
    return affine @ nibabel.affines.from_matvec(np.diag(np.array(block, float)), [(b - 1) / 2 for b in block])


def blurred(samples, sigma, affine):
    """scipy's filter, renormalised: over what there is, at borders and around NaN, which stays NaN."""
    sigmas = sigma / nibabel.affines.voxel_sizes(affine)
    there = np.isfinite(samples)
    one = gaussian_filter(there.astype(np.float64), sigmas, mode="constant")
    total = gaussian_filter(np.where(there, samples, 0.0).astype(np.float64), sigmas, mode="constant")
    with np.errstate(invalid="ignore"):
        return np.where(there, total / one, np.nan)


head = nibabel.load(ROOT / "testdata" / "ct_head.nii.gz")
oblique = np.array([[-0.9, 0.3, 0.1, 20], [0.25, 0.8, -0.2, -11], [0.05, 0.2, 2.0, 7], [0, 0, 0, 1.0]])
part = np.asanyarray(head.dataobj)[60:117, 40:95, 20:61].astype(np.int16)
path = save(part, oblique, "part.nii.gz")
holes = part.astype(np.float32)
holes[np.random.default_rng(1).random(part.shape) < 0.1] = np.nan
holes[10:20, 10:20, 10:20] = np.nan
holey = save(holes, oblique, "holes.nii")

for ranges in ("0:57,0:55,0:41", "5:40,11:12,3:30", "56:57,0:55,40:41"):
    slices = tuple(slice(*map(int, r.split(":"))) for r in ranges.split(","))
    cut = judge.folder / "cut.nii"
    nibabel.save(nibabel.load(path).slicer[slices], cut)
    same(judge.mesh([path, "--iso", 100, "--crop", ranges], f"crop {ranges}"), other([cut, "--iso", 100], f"nibabel's slicer {ranges}"), f"crop {ranges}")
whole = other([path, "--iso", 100, "--space", "voxel"], "whole, in voxels")
boxed = judge.mesh([path, "--iso", 100, "--space", "voxel", "--crop", "10:40,12:44,5:30"], "crop in voxels")
if whole and boxed:
    low, high = np.array((10, 12, 5)), np.array((39, 43, 29))
    inner = lambda p: p[((p > low) & (p < high)).all(axis=1)]
    away, _ = cKDTree(inner(whole[0])).query(inner(boxed[0]))
    judge.near(away.max(), 0, 1e-5, "crop in voxels: vertices off the cap are those of the whole volume")
# A box in millimetres: every sample that it holds is within, and no smaller box of samples covers it.
low, high = np.array((-20.0, 5.0, 30.0)), np.array((4.0, 31.0, 61.0))
corners = np.array([np.where(mask, high, low) for mask in np.ndindex(2, 2, 2)])
index = apply_affine(np.linalg.inv(nibabel.load(path).affine), corners)
first = np.maximum(np.floor(index.min(axis=0)), 0).astype(int)
last = np.minimum(np.ceil(index.max(axis=0)), np.array(part.shape) - 1).astype(int)
nibabel.save(nibabel.load(path).slicer[tuple(slice(a, b + 1) for a, b in zip(first, last))], cut)
for space, box in (("ras", zip(low, high)), ("lps", zip((-high[0], -high[1], low[2]), (-low[0], -low[1], high[2])))):
    text = ",".join(f"{a}:{b}" for a, b in box)
    found = judge.mesh([path, "--iso", 100, "--space", space, f"--crop-mm={text}"], f"crop-mm in {space}")
    same(found, other([cut, "--iso", 100, "--space", space], f"the least box, in {space}"), f"crop-mm in {space}")
judge.say("crop: as nibabel's slicer has it, in place, boxes in millimetres the least that cover")

for block in ((2, 2, 2), (3, 1, 2), (100, 4, 1)):
    text = "x".join(map(str, block))
    for name, source, samples in (("part", path, part), ("holes", holey, holes)):
        small = save(means(samples, block), centred(oblique, block, part.shape), "small.nii")
        found = judge.mesh([source, "--iso", 99.9, "--downsample", text], f"downsample {text} of {name}")
        same(found, other([small, "--iso", 99.9], f"numpy's means {text} of {name}"), f"downsample {text} of {name}")
judge.say("downsample: numpy's means, short blocks, NaN left out, the affine at the blocks' centres")

for name, source, samples in (("part", path, part), ("holes", holey, holes)):
    for sigma in (0.7, 2.5):
        wanted = blurred(samples, sigma, oblique)
        span = np.nanmax(wanted) - np.nanmin(wanted)
        for iso in (-300, 100.5):
            what = f"blur {sigma} of {name} at {iso}"
            found = judge.mesh([source, "--iso", iso, "--blur", sigma, "--space", "voxel"], what)
            if found is None:
                continue
            low, high = np.floor(found[0]).astype(int), np.ceil(found[0]).astype(int)
            inside = ((low >= 0) & (high < part.shape)).all(axis=1)
            # On grid edges only, between numbers, and not so near to an end that the vertex was held off it.
            on_edge = ((high - low).sum(axis=1) == 1) & inside
            points, low, high = found[0][on_edge], low[on_edge], high[on_edge]
            t = (points - low).sum(axis=1)
            a, b = wanted[tuple(low.T)], wanted[tuple(high.T)]
            fit = np.isfinite(a) & np.isfinite(b) & (np.abs(t - 0.5) < 0.498)
            value = a[fit] + t[fit] * (b - a)[fit]
            slack = 1e-5 * span + 4e-6 * np.abs(b - a)[fit]
            judge.expect(fit.sum() > 500, f"{what}: {fit.sum()} vertices to look at")
            judge.expect((np.abs(value - iso) <= slack).all(), f"{what}: scipy's value at the vertices is off by {np.abs(value - iso).max() / span:.1e} of the range")
    if name == "part":
        radius = [int(4 * 2.5 / s + 0.5) for s in nibabel.affines.voxel_sizes(oblique)]
        plainly = gaussian_filter(part.astype(np.float64), 2.5 / nibabel.affines.voxel_sizes(oblique))
        core = tuple(slice(r, n - r) for r, n in zip(radius, part.shape))
        judge.expect(np.abs(plainly - wanted)[core].max() < 1e-9 * span, "renormalising changes nothing away from the border")
judge.say("blur: within 1e-5 of the range of scipy's filter, renormalised at borders and around NaN")

# All of it together, always in the same order, with what surfaces there are, on every kind of input.
ranges = (slice(4, 50), slice(3, 51), slice(2, 39))
text = ["--crop", "4:50,3:51,2:39", "--downsample", "2x2x1", "--blur", "1.1"]
shifted = oblique @ nibabel.affines.from_matvec(np.eye(3), (4.0, 3.0, 2.0))


def all_steps(samples):
    small = means(blurred(samples[ranges], 1.1, oblique), (2, 2, 1))
    return save(small, centred(shifted, (2, 2, 1), (46, 48, 37)), "steps.nii")


for flags in ((), ("--invert",), ("--open",)):
    found = judge.mesh([path, "--iso", 99.9, *text, *flags], f"all steps {flags}", closed=flags != ("--open",))
    wanted = other([all_steps(part), "--iso", 99.9, *flags], f"all steps by numpy and scipy {flags}")
    same(found, wanted, f"all steps {flags}")
labels = np.digitize(part, (-500, 0, 100, 300)).astype(np.uint8)
labelled = save(labels, oblique, "labels.nii.gz")
found = judge.mesh([labelled, "--mask", "1,3", *text], "all steps of two labels")
same(found, other([all_steps(np.isin(labels, (1, 3)).astype(np.float64)), "--iso", 0.5], "two labels by numpy and scipy"), "all steps of two labels")
two = save(np.where(labels == 4, 7, 0).astype(np.int16), oblique, "two.nii")
same(judge.mesh([two, *text], "all steps of two values, no iso value"), other([two, "--iso", 3.5, *text], "at the half"), "two values")
raw = judge.raw(np.ascontiguousarray(part.transpose()).astype(">i2"), (0.9, 0.9, 2.1), (3, 4, 5), "part")
straight = nibabel.affines.from_matvec(np.diag((0.9, 0.9, 2.1)), (3, 4, 5))
same(judge.mesh([*raw, "--iso", 99.9, *text], "all steps of a raw file"), other([save(part, straight, "straight.nii.gz"), "--iso", 99.9, *text], "as NIfTI"), "raw and NIfTI")

folder = ROOT / "testdata" / "dicom" / "good-series"
reader = SimpleITK.ImageSeriesReader()
reader.SetFileNames(reader.GetGDCMSeriesFileNames(str(folder)))
image = reader.Execute()
nx, ny, nz = image.GetSize()
values = SimpleITK.GetArrayFromImage(image)
iso = float(values.min() + 0.4 * (float(values.max()) - float(values.min())))
SimpleITK.WriteImage(image[2 : nx - 1, 1 : ny - 2, 1:nz], judge.folder / "dicom.nii.gz")
found = judge.mesh([folder, "--iso", iso, "--crop", f"2:{nx - 1},1:{ny - 2},1:{nz}", "--downsample", "2x2x1"], "DICOM, cropped and downsampled")
wanted = other([judge.folder / "dicom.nii.gz", "--iso", iso, "--downsample", "2x2x1"], "as SimpleITK crops it")
if found and wanted and judge.expect(len(found[0]) == len(wanted[0]), "DICOM: as many vertices"):
    judge.near(cKDTree(wanted[0]).query(found[0])[0].max(), 0, 2e-3, "DICOM: furthest vertex, mm")
judge.say("crop, blur and downsample together: NIfTI, raw and DICOM, with --mask, --invert and --open")

# 32 GiB that are nowhere: only what lies in the box can have been read.
vast = judge.folder / "vast.raw"
with open(vast, "wb") as file:
    file.truncate(4096 * 4096 * 2048)
    for k in range(1500, 1510):
        for j in range(2000, 2010):
            file.seek((k * 4096 + j) * 4096 + 3000)
            file.write(b"\xff" * 10)
started = time.monotonic()
flags = ["--dims", "4096x4096x2048", "--type", "u8", "--crop", "2990:3020,1990:2020,1490:1520", "--space", "voxel"]
result = judge.mesh([vast, *flags], "a box of 32 GiB")
judge.expect(time.monotonic() - started < 60, f"a box of 32 GiB: {time.monotonic() - started:.0f} s")
if result:
    judge.near(np.abs(result[0].mean(axis=0) - (3004.5, 2004.5, 1504.5)).max(), 0, 1e-3, "a box of 32 GiB: its middle, in indices of the whole")
judge.finish()
