"""What the judges share: run mcubes, read a mesh as outsiders do, and look for every defect that the promise excludes.

A judge makes a `Judge`, calls `expect` and `mesh` on it and ends with `finish`, whose exit status is 1 if anything failed, or
if nothing was checked.
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pymeshlab
import trimesh

ROOT = Path(__file__).resolve().parents[2]
MCUBES = Path(os.environ.get("MCUBES", ROOT / "target" / "release" / "mcubes")).resolve()
TYPES = {"u1": "u8", "i1": "i8", "u2": "u16", "i2": "i16", "u4": "u32", "i4": "i32", "u8": "u64", "i8": "i64", "f4": "f32", "f8": "f64"}


class Judge:
    """Counts what was checked, in a temporary folder of its own."""

    def __init__(self, name):
        self.name = name
        self.folder_guard = tempfile.TemporaryDirectory(prefix=f"mcubes-{name}-")
        self.folder = Path(self.folder_guard.name)
        self.checked = self.meshes = self.triangles = self.merged = 0
        self.failures = []

    def expect(self, truth, what):
        """One statement that must be true."""
        self.checked += 1
        if not truth:
            self.failures.append(what)
            print(f"  FAILED  {what}", flush=True)
        return bool(truth)

    def near(self, found, wanted, tolerance, what):
        """A number that must be within an absolute tolerance."""
        return self.expect(abs(found - wanted) <= tolerance, f"{what}: found {found:.9g}, expected {wanted:.9g} within {tolerance:.3g}")

    def say(self, text):
        print(f"  {text}", flush=True)

    def finish(self):
        """Prints the sum and leaves."""
        if not self.checked:
            self.failures.append("nothing was checked")
        state = "FAILED" if self.failures else "passed"
        print(
            f"{self.name}: {state}; {self.checked} checks on {self.meshes} meshes with {self.triangles} triangles, "
            f"{len(self.failures)} failed",
            flush=True,
        )
        self.folder_guard.cleanup()
        sys.exit(1 if self.failures else 0)

    def run(self, arguments, output, what):
        """Runs mcubes; True if it ended with status 0 and left the file."""
        done = subprocess.run([MCUBES, *map(str, arguments), "-q", "-o", output], capture_output=True, text=True, timeout=600)
        return self.expect(done.returncode == 0 and Path(output).exists(), f"{what}: exit status {done.returncode}: {done.stderr.strip()}")

    def raw(self, volume, spacing=(1, 1, 1), origin=(0, 0, 0), name="volume"):
        """Writes an array (z, y, x) as a raw file; returns the arguments that read it."""
        path = self.folder / f"{name}.raw"
        volume = np.ascontiguousarray(volume)
        volume.tofile(path)
        nz, ny, nx = volume.shape
        big = volume.dtype.byteorder == ">"
        return [
            path, "--dims", f"{nx}x{ny}x{nz}", "--type", TYPES[volume.dtype.str[1:]], "--endian", "big" if big else "little",
            "--spacing", "x".join(map(repr, map(float, spacing))), "--origin", ",".join(map(repr, map(float, origin))),
        ]

    def mesh(self, arguments, what, closed=True):
        """Makes PLY and STL of one surface, has both judged, and returns the PLY's points (f64) and triangles, or None."""
        result = None
        for kind in ("ply", "stl"):
            path = self.folder / f"mesh.{kind}"
            path.unlink(missing_ok=True)
            if self.run(arguments, path, f"{what} as {kind}"):
                found = self.look(path, f"{what} as {kind}", closed)
                if kind == "ply":
                    result = found
                else:
                    self.expect(result is None or len(found[1]) == len(result[1]), f"{what}: STL and PLY have as many triangles")
                    self.expect(result is None or self.merged == len(result[0]), f"{what}: STL merges to the vertices of the PLY")
        return result

    def look(self, path, what, closed=True):
        """Every defect that the promise excludes, by trimesh, by pymeshlab, and by counting. Returns points, triangles as stored."""
        mesh = trimesh.load(path, process=False, force="mesh")
        points, faces = np.asarray(mesh.vertices, np.float64), np.asarray(mesh.faces)
        self.meshes += 1
        self.triangles += len(faces)
        if not self.expect(len(faces) > 0, f"{what}: has triangles"):
            return points, faces
        self.expect(np.isfinite(points).all(), f"{what}: all coordinates are finite")
        self.expect(len(np.unique(faces)) == len(points), f"{what}: no unused vertex")
        unique, index = distinct(points.astype(np.float32))
        self.merged = len(unique)
        if path.suffix != ".stl":
            self.expect(len(unique) == len(points), f"{what}: no two vertices at one point")
        merged = index[faces]
        self.count(unique.astype(np.float64), merged, what, closed)

        merged_mesh = trimesh.Trimesh(unique.astype(np.float64), merged, process=False, validate=False)
        self.expect(merged_mesh.is_winding_consistent, f"{what}: trimesh finds the winding consistent")
        if closed:
            self.expect(merged_mesh.is_watertight, f"{what}: trimesh finds it watertight")
            self.expect(merged_mesh.volume > 0, f"{what}: trimesh finds a positive volume, {merged_mesh.volume}")

        sets = pymeshlab.MeshSet(verbose=False)
        sets.load_new_mesh(str(path))
        sets.meshing_remove_duplicate_vertices()
        self.expect(sets.current_mesh().vertex_number() == len(unique), f"{what}: pymeshlab merges to as many vertices")
        seen = sets.get_topological_measures()
        self.expect(seen["is_mesh_two_manifold"], f"{what}: pymeshlab finds it two-manifold")
        for key in ("non_two_manifold_edges", "non_two_manifold_vertices", "unreferenced_vertices") + (("boundary_edges",) if closed else ()):
            self.expect(seen[key] == 0, f"{what}: pymeshlab counts {seen[key]} {key}")
        before = sets.current_mesh().face_number()
        sets.meshing_remove_duplicate_faces()
        sets.meshing_remove_null_faces()
        after = sets.current_mesh().face_number()
        self.expect(before == after == len(faces), f"{what}: pymeshlab removes {before - after} duplicate or empty faces")
        return points, faces

    def count(self, points, faces, what, closed):
        """Edges, faces and areas by plain counting."""
        n = np.int64(len(points))
        start, end = faces.reshape(-1).astype(np.int64), np.roll(faces, -1, axis=1).reshape(-1).astype(np.int64)
        self.expect((start != end).all(), f"{what}: no face uses a vertex twice")
        forward = start * n + end
        unique = np.unique(forward)
        self.expect(len(unique) == len(forward), f"{what}: no edge is used twice in one direction")
        if closed:
            self.expect(np.array_equal(unique, np.unique(end * n + start)), f"{what}: every edge is used once in each direction")
        self.expect(len(distinct(np.sort(faces, axis=1))[0]) == len(faces), f"{what}: no duplicate face")
        a, b, c = points[faces[:, 0]], points[faces[:, 1]], points[faces[:, 2]]
        double_area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
        self.expect((double_area > 0).all(), f"{what}: {np.count_nonzero(double_area == 0)} faces of zero area")


def distinct(rows):
    """Equal rows merged, as a reader of STL does with points: the distinct rows, and for each row the index of its own."""
    order = np.lexsort(rows.T)
    ordered = rows[order]
    first = np.ones(len(rows), bool)
    first[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    index = np.empty(len(rows), np.int64)
    index[order] = np.cumsum(first) - 1
    return ordered[first], index


def euler(points, faces):
    """Vertices less edges plus faces."""
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    return len(points) - len(distinct(edges)[0]) + len(faces)


def area_volume(points, faces):
    """Area and enclosed volume, in f64."""
    mesh = trimesh.Trimesh(points, faces, process=False, validate=False)
    return mesh.area, mesh.volume
