"""Starts the programs that are compared, each in a process of its own, and takes time and memory."""

import json
import os
import subprocess
import sys
import time
from collections import namedtuple
from pathlib import Path

from volumes import WORK, make

RELEASE = WORK.parent / "release"
Run = namedtuple("Run", "seconds mib")
CALLS = 4


def seconds(arguments):
    """Wall time and peak resident memory of a process, its start included."""
    line = [sys.executable, "-S", Path(__file__).with_name("timed.py"), *arguments]
    found = subprocess.run([str(a) for a in line], check=True, capture_output=True, text=True)
    return Run(**json.loads(found.stdout))


def command(source, target, iso, threads):
    """The command line of mcubes."""
    return [RELEASE / "mcubes", source, "--iso", str(iso), "-o", target, "-q", "--threads", str(threads)]


def call(peer, *arguments):
    """A command line that runs one of the functions below in Python."""
    return [sys.executable, __file__, peer, *map(str, arguments)]


def kernel_ms(program, name, size, iso, threads, cpu="", normals="no"):
    """The median of some calls after the first; triangles; memory."""
    volume = make(name, size, ".npy")
    if program == "mcubes":
        line = [RELEASE / "examples/kernel", "--vol", volume, "--iso", iso, "--threads", threads, "--again", CALLS, "--normals", normals]
    else:
        line = call(program, volume, iso, threads)
    environment = {**os.environ, **({"MCUBES_CPU": cpu} if cpu else {})}
    found = subprocess.run([str(a) for a in line], check=True, capture_output=True, text=True, env=environment)
    found = json.loads(found.stdout)
    ms = sorted(found["ms"][1:] or found["ms"])
    return {"ms": ms[len(ms) // 2], "triangles": found["triangles"], "mib": found.get("rss_extra_mib", 0)}


def timed(function, calls):
    ms = []
    for _ in range(calls):
        begun = time.perf_counter()
        triangles = function()
        ms.append(1e3 * (time.perf_counter() - begun))
    print(json.dumps({"ms": ms, "triangles": triangles}))


def flying_edges(samples, iso):
    import vtk
    from vtk.util.numpy_support import numpy_to_vtk

    image = vtk.vtkImageData()
    image.SetDimensions(*samples.shape[::-1])
    image.GetPointData().SetScalars(numpy_to_vtk(samples.ravel(), deep=False))

    def run():
        contour = vtk.vtkFlyingEdges3D()
        contour.SetInputData(image)
        contour.SetValue(0, iso)
        contour.ComputeNormalsOff()
        contour.ComputeGradientsOff()
        contour.ComputeScalarsOff()
        contour.Update()
        return contour

    return run


def vtk_threads(threads):
    import vtk

    vtk.vtkSMPTools.SetBackend("STDThread")
    vtk.vtkSMPTools.Initialize(threads)


def main(peer, *arguments):
    import numpy as np

    if peer == "vtk-command":
        import nibabel
        import vtk

        source, target, threads = arguments
        vtk_threads(int(threads))
        samples = np.ascontiguousarray(np.asarray(nibabel.load(source).dataobj).transpose(2, 1, 0))
        writer = vtk.vtkSTLWriter()
        writer.SetInputData(flying_edges(samples, 300)().GetOutput())
        writer.SetFileTypeToBinary()
        writer.SetFileName(target)
        writer.Write()
        return
    path, iso, threads = arguments
    samples, iso = np.load(path), float(iso)
    if peer == "vtk":
        vtk_threads(int(threads))
        run = flying_edges(samples, iso)
        timed(lambda: run().GetOutput().GetNumberOfCells(), 1 + CALLS)
    elif peer == "scikit-image":
        from skimage.measure import marching_cubes

        timed(lambda: len(marching_cubes(samples, iso, method="lorensen")[1]), 1)
    elif peer == "PyMCubes":
        import mcubes

        timed(lambda: len(mcubes.marching_cubes(samples, iso)[1]), 1)


if __name__ == "__main__":
    main(*sys.argv[1:])
