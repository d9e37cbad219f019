"""Runs the Snakemake workflow and the Slurm script's command on a small tree of scans, one of them broken.

MCUBES names the binary. Exits with 1 at the first thing that is not as promised.
"""

import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

import trimesh

ROOT = pathlib.Path(__file__).resolve().parents[2]
MCUBES = str(pathlib.Path(os.environ["MCUBES"]).resolve())
SYNTH = ROOT / "testdata/nifti/synth"
GOOD = {"a/u8": "t_u8_le.nii", "a/i8": "t_i8_le.nii", "b/c/deep": "n2_u8_le.nii.gz"}
SERIES = "study/series"


def check(is_so, what):
    if not is_so:
        sys.exit(f"not as promised: {what}")


def tree(folder):
    for name, source in GOOD.items():
        target = folder / f"{name}{''.join(pathlib.Path(source).suffixes)}"
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(SYNTH / source, target)
    shutil.copytree(ROOT / "testdata/dicom/good-series", folder / SERIES)
    shutil.copy(ROOT / "testdata/nifti/bad/trunc_data.nii", folder / "b/cut.nii")


def snakemake(folder):
    command = [sys.executable, "-m", "snakemake", "--snakefile", str(ROOT / "workflows/snakemake/Snakefile")]
    command += ["--cores", "2", "--keep-going", "--nocolor", "--config", f"mcubes={MCUBES}", "input=in", "output=out"]
    command += ["options=--iso 50"]
    run = subprocess.run(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    lines = (folder / "out/report.jsonl").read_text().splitlines()
    return run, [json.loads(line) for line in lines]


def times(folder):
    return {p: p.stat().st_mtime_ns for p in folder.rglob("*.stl")}


def workflow(folder):
    run, report = snakemake(folder)
    check(run.returncode != 0, f"a broken scan fails the workflow\n{run.stdout}")
    meshes = {str(p.relative_to(folder / "out/meshes").with_suffix("")) for p in folder.rglob("*.stl")}
    check(meshes == {*GOOD, SERIES}, f"the good scans are meshed: {sorted(meshes)}\n{run.stdout}")
    for path in folder.rglob("*.stl"):
        check(trimesh.load_mesh(path).is_watertight, f"{path} is closed")
    failed = [line for line in report if line["status"] == "failed"]
    check(len(report) == len(GOOD) + 2, f"the report has a line a scan: {report}")
    check([line["input"] for line in failed] == ["in/b/cut.nii"], f"the report names the bad one: {failed}")
    check(failed[0]["error"]["kind"] == "truncated-data", f"and says why: {failed}")

    before = times(folder)
    run, report = snakemake(folder)
    check(run.returncode != 0, "the broken scan fails again")
    check(times(folder) == before, "what is done is not done again")
    check(run.stdout.count("rule mesh:") == 1, f"only what is missing is tried\n{run.stdout}")
    check(len(report) == len(GOOD) + 2, f"the report is whole: {report}")

    shutil.copy(SYNTH / "t_u8_le.nii", folder / "in/b/cut.nii")
    run, report = snakemake(folder)
    check(run.returncode == 0, f"mended, it comes to its end\n{run.stdout}")
    check(all(line["status"] == "ok" for line in report), f"the report says so: {report}")
    after = times(folder)
    check({p: t for p, t in after.items() if p in before} == before, "the others are left alone")
    check(len(after) == len(before) + 1, "the mended scan is meshed")


def slurm(folder):
    script = str(ROOT / "workflows/slurm/mcubes.sbatch")
    for _ in range(2):
        statuses = []
        for task in (1, 2, 3):
            env = {**os.environ, "MCUBES": MCUBES, "SLURM_ARRAY_TASK_ID": str(task), "SLURM_ARRAY_TASK_COUNT": "3"}
            run = subprocess.run([script, "in", "meshes", "--iso", "50"], cwd=folder, env=env, stderr=subprocess.PIPE)
            statuses.append(run.returncode)
        check(sorted(statuses) == [0, 0, 1], f"one task has the broken scan: {statuses}")
    meshes = {str(p.relative_to(folder / "meshes").with_suffix("")) for p in folder.rglob("*.stl")}
    check(meshes == {*GOOD, SERIES}, f"the tasks together mesh all: {sorted(meshes)}")
    report = [json.loads(s) for p in folder.glob("meshes/report-*.jsonl") for s in p.read_text().splitlines()]
    found = sorted(line["status"] for line in report)
    check(found == ["failed"] + ["skipped"] * 4, f"a second array does only what is missing: {found}")


for part in (workflow, slurm):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        tree(folder / "in")
        part(folder)
        print(f"{part.__name__}: as promised")
