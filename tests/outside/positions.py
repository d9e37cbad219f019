"""A marked sample lands on the millimetre that nibabel says: all 48 axis orders and directions, oblique, sheared, each way to give a place."""

import itertools

import nibabel
import numpy as np

from judge import Judge

judge = Judge("positions")
DIMS, MARK = (7, 8, 9), (2, 5, 3)


def marked(kind=np.int16, value=2):
    samples = np.zeros(DIMS, kind)
    samples[MARK] = value
    return samples


def lands(path, what, flags=(), turn=(1, 1, 1), wanted=None, iso=1, tolerance=1e-4):
    """The mesh around the marked sample is centred on nibabel's position of it."""
    if wanted is None:
        wanted = nibabel.affines.apply_affine(nibabel.load(path).affine, MARK) * turn
    result = judge.mesh([path, "--iso", iso, *flags], what)
    if result is None:
        return
    points, _ = result
    judge.expect(len(points) == 6, f"{what}: one vertex on each of the six grid edges of the marked sample, found {len(points)}")
    found = points.mean(axis=0)
    judge.expect(np.abs(found - wanted).max() <= tolerance, f"{what}: found {found}, nibabel says {wanted}")


def save(image, name):
    path = judge.folder / name
    nibabel.save(image, path)
    return path


zooms, origin = np.array((0.8, 1.5, 2.25)), np.array((-71.5, 33.25, 12.125))
for order in itertools.permutations(range(3)):
    for signs in itertools.product((1, -1), repeat=3):
        affine = np.eye(4)
        affine[:3, :3] = 0
        for axis in range(3):
            affine[order[axis], axis] = signs[axis] * zooms[axis]
        affine[:3, 3] = origin
        code = "".join(nibabel.aff2axcodes(affine))
        image = nibabel.Nifti1Image(marked(), affine)
        image.set_sform(affine, code=1)
        image.set_qform(None, code=0)
        lands(save(image, f"{code}.nii"), f"sform {code}")
        image.set_sform(None, code=0)
        image.set_qform(affine, code=1)
        lands(save(image, f"{code}q.nii.gz"), f"qform {code}")
judge.say("all 48 axis orders and directions, as sform and as qform")

turn_x, turn_z = 0.4, -0.9
rotation = np.array([[np.cos(turn_z), -np.sin(turn_z), 0], [np.sin(turn_z), np.cos(turn_z), 0], [0, 0, 1]]) @ np.array(
    [[1, 0, 0], [0, np.cos(turn_x), -np.sin(turn_x)], [0, np.sin(turn_x), np.cos(turn_x)]]
)
oblique, sheared = np.eye(4), np.eye(4)
oblique[:3, :3], oblique[:3, 3] = rotation * zooms, origin
sheared[:3, :3], sheared[:3, 3] = rotation @ np.array([[1, 0.3, 0], [0, 1, -0.45], [0, 0, 1]]) * zooms * (-1, 1, 1), origin
for name, affine, codes in (("oblique", oblique, ("sform", "qform")), ("sheared", sheared, ("sform",))):
    for code in codes:
        image = nibabel.Nifti1Image(marked(), affine)
        image.set_sform(affine if code == "sform" else None, code=int(code == "sform"))
        image.set_qform(affine if code == "qform" else None, code=int(code == "qform"))
        path = save(image, f"{name}-{code}.nii")
        lands(path, f"{name} {code}")
        lands(path, f"{name} {code} in LPS", ("--space", "lps"), (-1, -1, 1))
        lands(path, f"{name} {code} in voxels", ("--space", "voxel"), wanted=np.array(MARK))
judge.say("oblique and sheared, in RAS, LPS and voxels")

image = nibabel.Nifti1Image(marked(), None)
image.header.set_zooms(zooms)
image.set_sform(None, code=0)
image.set_qform(None, code=0)
lands(save(image, "noform.nii"), "neither sform nor qform")
image = nibabel.Nifti2Image(marked(np.float32), oblique)
lands(save(image, "two.nii"), "NIfTI-2")
image = nibabel.Nifti1Pair(marked(np.uint8), sheared)
lands(save(image, "pair.img"), "a pair .hdr and .img")
image = nibabel.Nifti1Image(marked(np.int16, 40), oblique)
image.header.set_slope_inter(0.5, -1000)
path = save(image, "scaled.nii")
samples = np.asanyarray(nibabel.load(path).dataobj)
lands(path, "scaled samples", iso=(samples.max() + samples.min()) / 2)
judge.say("no place given, NIfTI-2, pairs, scaled samples")

samples = marked().transpose()
arguments = judge.raw(samples, spacing=zooms, origin=origin)
result = judge.mesh([*arguments, "--iso", 1], "raw with spacing and origin")
if result is not None:
    wanted = origin + zooms * MARK
    judge.expect(np.abs(result[0].mean(axis=0) - wanted).max() <= 1e-4, f"raw: found {result[0].mean(axis=0)}, expected {wanted}")
judge.finish()
