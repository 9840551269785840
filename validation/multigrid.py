#!/usr/bin/env python3
"""Iterations, time and memory of `linear.solver = "multigrid"` on several meshes, and how they depend on parameters.

usage: multigrid.py PROGRAM [growth | parameters | direct] [CASE ...]
       multigrid.py PROGRAM [million | rest]

Prints rows of the tables of multigrid.md. Times are those of one thread; `µs` is processor time per unknown and step.
"""

import json
import subprocess
import sys
import tempfile

TUBE = ["mesh.cells=[10,4,1]", "mesh.grading=0", "time.step=1e-4", "time.end=5e-4"]
BOX = ["mesh.grading=0", "time.step=0.01", "time.end=0.05", "time.scheme=bdf2"]
CASES = {
    "cfd3": (["time.step=0.005", "time.end=0.025"], [1, 2, 3]),
    "fsi2": (["time.step=0.005", "time.end=0.025"], [1, 2, 3]),
    "fsi3": (["time.step=0.005", "time.end=0.025"], [1, 2, 3]),
    "rotor": (["time.end=0.05"], [1, 2, 3]),
    "dfg-3d1z": (["mesh.extrude.layers=2", "mesh.extrude.grading=0"], [1, 2]),
    "tube": (TUBE, [1, 2, 3]),
    "fsi-box": (BOX, [1, 2]),
}
TEN = ["mesh.grading=0", "time.step=1e-4", "time.end=1e-3"]
MILLION = [("[10,4,1]", 1), ("[10,4,1]", 2), ("[34,4,1]", 2), ("[10,4,1]", 3)]
REST = {"fsi1": ([], [1, 2, 3]), "csm1": ([], [2]), "fsi-box": (["mesh.grading=0"], [1])}
PARAMETERS = {
    "as it is": [],
    "body 1000 times stiffer": ["solid.mu=2e9", "solid.lambda=8e9"],
    "body 1000 times softer": ["solid.mu=2e3", "solid.lambda=8e3"],
    "density of the body 100": ["solid.density=100"],
    "density of the body 10 000": ["solid.density=10000"],
    "k = 1e-4 s": ["time.step=1e-4", "time.end=5e-4"],
    "k = 1e-2 s": ["time.step=1e-2", "time.end=5e-2"],
}


def run(program, case, sets, solver="multigrid"):
    with tempfile.TemporaryDirectory() as out:
        command = [program, "run", case, "-o", out, "--force", "--quiet", "--threads", "1"]
        for item in [*sets, "output.fields-every=0", f"linear.solver={solver}"]:
            command += ["--set", item]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode != 0:
            return None, done.stderr.strip().splitlines()[-1]
        with open(f"{out}/summary.json", encoding="utf-8") as file:
            return json.load(file), ""


def row(label, program, case, sets, solver="multigrid"):
    summary, error = run(program, case, sets, solver)
    if summary is None:
        print(f"| {label} | {error} |")
        return
    unknowns, steps = summary["unknowns"]["total"], max(summary["steps"], 1)
    newton = summary["newton_steps"]
    each = summary["linear_iterations"] / newton
    micro = 1e6 * summary["cpu_seconds"] / unknowns / steps
    solve = 1e6 * summary["phases"]["solve"] / unknowns / steps
    memory = summary["peak_memory_bytes"] / unknowns / 1e3
    print(
        f"| {label} | {unknowns} | {newton / steps:.1f} | {each:.1f} | {summary['direct_fallbacks']} "
        f"| {micro:.0f} | {solve:.0f} | {memory:.1f} |",
        flush=True,
    )


def main():
    program, what, *names = sys.argv[1:]
    print("| run | unknowns | Newton | iterations | fallbacks | µs | of these solving | kB per unknown |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- |")
    for cells, refine in MILLION if what == "million" else []:
        sets = [*TEN, f"mesh.cells={cells}", f"mesh.refine={refine}"]
        row(f"`tube`, {cells}, refine {refine}", program, "tube", sets)
    for name, (sets, refinements) in REST.items() if what == "rest" else []:
        for refine in refinements:
            label = f"`{name}`, refine {refine}"
            row(label, program, name, [*sets, f"mesh.refine={refine}"])
            if name != "fsi-box":
                row(f"{label}, direct", program, name, [*sets, f"mesh.refine={refine}"], "multifrontal")
    for name in [] if what in ("million", "rest") else names or CASES:
        sets, refinements = CASES[name]
        if what == "parameters":
            for label, more in PARAMETERS.items():
                row(f"`{name}`, {label}", program, name, [*sets, "mesh.refine=2", *more])
            continue
        for refine in refinements:
            label = f"`{name}`, refine {refine}"
            if what == "direct":
                row(f"{label}, direct", program, name, [*sets, f"mesh.refine={refine}"], "multifrontal")
            row(label, program, name, [*sets, f"mesh.refine={refine}"])


main()
