#!/usr/bin/env python3
"""Runs mcubes and what people use instead side by side, and prints tables of medians and ratios.

    benches/peers/run.py [--size 512] [--rounds 5] [--parts kernel,normals,command,growth,huge]

Installs its peers into target/peers/venv, builds mcubes in release mode, makes its volumes in
target/peers. In each round every program runs once, one after the other, so that a machine that
gets slower slows all of them; ratios are taken within a round. Nothing else should run.
"""

import argparse
import os
import statistics
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
TARGET = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
WORK = TARGET / "peers"


def enter_venv():
    """Runs this script again by the environment's Python, which it makes if it must."""
    python = WORK / "venv/bin/python"
    wanted = (HERE / "requirements.txt").read_text()
    stamp = WORK / "venv/requirements.txt"
    if not stamp.exists() or stamp.read_text() != wanted:
        WORK.mkdir(parents=True, exist_ok=True)
        subprocess.run([sys.executable, "-m", "venv", WORK / "venv"], check=True)
        subprocess.run([python, "-m", "pip", "install", "-q", "-r", HERE / "requirements.txt"], check=True)
        stamp.write_text(wanted)
    if Path(sys.prefix).resolve() != (WORK / "venv").resolve():
        os.execv(python, [str(python), __file__, *sys.argv[1:]])


enter_venv()

from volumes import VOLUMES, make  # noqa: E402
from programs import call, command, kernel_ms, seconds  # noqa: E402


def median(values):
    return statistics.median(values)


def table(title, head, rows):
    print(f"\n## {title}\n")
    print("| " + " | ".join(head) + " |")
    print("|" + "---|" * len(head))
    for row in rows:
        print("| " + " | ".join(row) + " |")
    sys.stdout.flush()


def kernel(size, rounds):
    """Volume in memory to mesh in memory, against Flying Edges."""
    rows = []
    for name, volume in VOLUMES.items():
        for threads, cpu in [(1, ""), (2, ""), (1, "avx2"), (1, "sse2"), (1, "scalar")]:
            if cpu and name != "ct-i16":
                continue
            ours, theirs = [], []
            for _ in range(rounds):
                ours.append(kernel_ms("mcubes", name, size, volume.iso, threads, cpu))
                theirs.append(kernel_ms("vtk", name, size, volume.iso, threads))
            ratio = median(t["ms"] / o["ms"] for o, t in zip(ours, theirs))
            rows.append([
                name + (f", {cpu} at most" if cpu else ""), str(threads),
                f"{median(o['triangles'] for o in ours):,.0f}",
                f"{median(o['ms'] for o in ours):.1f}", f"{median(t['ms'] for t in theirs):.1f}",
                f"**{ratio:.1f}**", f"{median(o['mib'] for o in ours):.0f}",
            ])
    table(f"Kernel, {size}^3, milliseconds", ["volume", "threads", "triangles", "mcubes", "Flying Edges", "times faster", "mcubes, MiB beside the volume"], rows)
    rows = []
    for peer in ["scikit-image", "PyMCubes"]:
        o = kernel_ms("mcubes", "ct-i16", size, VOLUMES["ct-i16"].iso, 1)
        t = kernel_ms(peer, "ct-i16", size, VOLUMES["ct-i16"].iso, 1)
        rows.append([peer, f"{o['ms']:.0f}", f"{t['ms']:.0f}", f"{t['ms'] / o['ms']:.0f}"])
    table("Kernel against others, ct-i16, one thread, once", ["program", "mcubes ms", "its ms", "times faster"], rows)


def normals(size, rounds):
    """What a normal a vertex costs, against the kernel without."""
    rows = []
    for name, volume in VOLUMES.items():
        if name == "empty-i16":
            continue
        without, more = [], []
        for _ in range(rounds):
            for asked, into in (("no", without), ("yes", more)):
                into.append(kernel_ms("mcubes", name, size, volume.iso, 1, normals=asked)["ms"])
        ratio = median(b / a for a, b in zip(without, more))
        rows.append([name, f"{median(without):.1f}", f"{median(more):.1f}", f"{100 * ratio - 100:.0f} %"])
    table(f"Normals, kernel, {size}^3, one thread, milliseconds", ["volume", "without", "with", "more"], rows)


def whole_command(size, rounds):
    """File to file, against reading and copying alone, and against Python with VTK."""
    nii, gz = make("ct-i16", size, ".nii"), make("ct-i16", size, ".nii.gz")
    out, copy = WORK / "out.stl", WORK / "copy.stl"
    mcubes = lambda source, end, threads: command(source, WORK / f"out.{end}", 300, threads)
    figures = {}
    subprocess.run(mcubes(nii, "stl", 2), check=True)
    for _ in range(rounds):
        def note(key, arguments, made=None):
            if made:
                Path(made).unlink(missing_ok=True)
            figures.setdefault(key, []).append(seconds(arguments))
        note("cat", ["cat", nii])
        note("cp", ["cp", out, copy], copy)
        for threads in (1, 2):
            for end in ("stl", "ply", "obj"):
                note(f"nii to {end}, {threads}", mcubes(nii, end, threads), WORK / f"out.{end}")
        note("inflate", [str(TARGET / "release/examples/inflate"), str(gz)])
        note("gz to stl, 2", mcubes(gz, "stl", 2), out)
        note("VTK nii to stl, 2", call("vtk-command", nii, WORK / "vtk.stl", 2), WORK / "vtk.stl")
        note("VTK gz to stl, 2", call("vtk-command", gz, WORK / "vtk.stl", 2), WORK / "vtk.stl")
    ms = {key: [1e3 * s.seconds for s in values] for key, values in figures.items()}
    mib = {key: max(s.mib for s in values) for key, values in figures.items()}
    copying = [a + b for a, b in zip(ms["cat"], ms["cp"])]
    base = {"gz to stl, 2": ("inflating alone", ms["inflate"])}
    rows = []
    for key, values in ms.items():
        against, reference = base.get(key, ("cat + cp", copying))
        if key.endswith((" ply, 1", " obj, 1")):
            against, reference = "STL", ms["nii to stl, 1"]
        if key.endswith((" ply, 2", " obj, 2")):
            against, reference = "STL", ms["nii to stl, 2"]
        ratio = median(a / b for a, b in zip(values, reference))
        rows.append([key, f"{median(values):.0f}", f"{ratio:.2f} x {against}", f"{mib[key]:.0f}"])
    table(f"Whole command, ct-i16 {size}^3 (the number is threads)", ["what", "ms", "ratio", "peak MiB"], rows)


def growth(rounds):
    """Time per voxel as volumes grow, and two threads against one."""
    rows = []
    for name in ("ct-i16", "gyroid-56-i16"):
        for size in (256, 512, 768):
            per = {}
            for threads in (1, 2):
                runs = [kernel_ms("mcubes", name, size, VOLUMES[name].iso, threads)["ms"] for _ in range(rounds)]
                per[threads] = median(runs)
            rows.append([name, f"{size}^3", f"{1e6 * per[1] / size**3:.3f}", f"{per[1] / per[2]:.2f}"])
    table("Growth, kernel", ["volume", "size", "ns a voxel, one thread", "two threads over one"], rows)


def huge():
    """2048^3 int16: a sparse file with a few balls in it, and reading it alone."""
    path = make("balls", 2048, ".raw")
    mesh = [*command(path, WORK / "huge.stl", 300, 2), "--dims", "2048x2048x2048", "--type", "i16"]
    seconds(["cat", path])  # Brings it into the page cache, which the table is about.
    cat, run = seconds(["cat", path]), seconds(mesh)
    (WORK / "huge.stl").unlink()
    row = [f"{run.seconds:.1f}", f"{run.mib:.0f}", f"{1e9 * run.seconds / 2048**3:.3f}", f"{cat.seconds:.1f}"]
    table("2048^3 int16 (17 GB, sparse), two threads", ["seconds", "peak MiB", "ns a voxel", "cat alone, seconds"], [row])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--size", type=int, default=512)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--parts", default="kernel,normals,command,growth,huge")
    given = parser.parse_args()
    build = ["cargo", "build", "--release", "--locked", "--bin", "mcubes", "--example", "kernel", "--example", "inflate"]
    subprocess.run(build, check=True, cwd=ROOT)
    parts = {
        "kernel": lambda: kernel(given.size, given.rounds),
        "normals": lambda: normals(given.size, given.rounds),
        "command": lambda: whole_command(given.size, given.rounds),
        "growth": lambda: growth(given.rounds),
        "huge": huge,
    }
    for part in given.parts.split(","):
        parts[part]()


if __name__ == "__main__":
    main()
