"""The judges themselves: a sound mesh passes, and each kind of defect put into it is found."""

import contextlib
import io

import numpy as np
import trimesh

from judge import Judge

judge = Judge("defects")
sphere = trimesh.creation.icosphere(subdivisions=2)
points, faces = np.asarray(sphere.vertices), np.asarray(sphere.faces)


def failures(points, faces, kind="ply"):
    """How many complaints a mesh gives."""
    path = judge.folder / f"defect.{kind}"
    trimesh.Trimesh(points, faces, process=False, validate=False).export(path)
    inner = Judge("inner")
    with contextlib.redirect_stdout(io.StringIO()):
        inner.look(path, "mesh")
    inner.folder_guard.cleanup()
    return len(inner.failures)


for kind in ("ply", "stl"):
    found = failures(points, faces, kind)
    judge.expect(found == 0, f"a sound sphere as {kind}: {found} complaints")
flipped = faces.copy()
flipped[7] = flipped[7, ::-1]
touching = points.copy()
touching[faces[-1][0]] = touching[faces[0][0]]
apart = np.concatenate([points, points + (2 * points[0])])
second = np.concatenate([faces, faces + len(points)])
opposite = int(np.argmin(points @ points[0]))
pinched = np.where(second == len(points) + opposite, 0, second)
apart[len(points) + opposite] = apart[0]
used = np.unique(pinched)
number = np.zeros(len(apart), int)
number[used] = np.arange(len(used))
defects = {
    "a missing triangle": (points, faces[1:]),
    "one triangle turned round": (points, flipped),
    "all triangles turned round": (points, faces[:, ::-1]),
    "a triangle twice": (points, np.concatenate([faces, faces[:1]])),
    "two vertices at one place": (touching, faces),
    "an unused vertex": (np.concatenate([points, [[5, 5, 5]]]), faces),
    "a coordinate that is not a number": (np.where(np.arange(len(points))[:, None] == 3, np.nan, points), faces),
    "two spheres that share a vertex": (apart[used], number[pinched]),
}
for what, (p, f) in defects.items():
    judge.expect(failures(p, f) > 0, f"{what} is found")
judge.say(f"{len(defects)} kinds of defect are found")
judge.finish()
