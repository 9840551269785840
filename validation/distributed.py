#!/usr/bin/env python3
"""Runs of several processes beside those of one, for distributed.md.

usage: distributed.py PROGRAM same [CASE ...]   every case on 1 to 4 processes against Undula's own solver
       distributed.py PROGRAM memory            memory of each of 4 processes against that of one
       distributed.py PROGRAM counts            cells, copies, bytes and messages on 2 to 16 processes
       distributed.py PROGRAM scaling           two processes against two threads
       distributed.py PROGRAM multigrid         iterations, agreement, memory and time of 1 to 4 processes

Prints rows of the tables of distributed.md; exit code 1 where a bound is not met. `mpirun` and PETSc must be there.
"""

import csv
import json
import os
import statistics
import subprocess
import sys
import tempfile

COARSE = ["mesh.refine=0"]
SHORT = ["mesh.refine=0", "time.end=0.02"]
TUBE = ["mesh.grading=0", "time.step=1e-4"]
CASES = {
    "cfd1": COARSE, "cfd2": COARSE, "cfd3": SHORT,
    "csm1": COARSE, "csm2": COARSE, "csm3": SHORT,
    "fsi1": COARSE, "fsi2": SHORT, "fsi3": SHORT,
    "dfg-2d1": COARSE, "dfg-2d2": SHORT, "dfg-2d3": SHORT,
    "rotor": ["mesh.refine=0", "time.end=0.04"], "flap": ["mesh.refine=0", "time.end=0.03"],
    "cavity": ["mesh.refine=0", "time.end=0.3"], "tube-2d": ["mesh.refine=0", "time.end=3e-4"],
    "cylinder": SHORT, "pump": ["mesh.refine=0", "time.end=0.05"], "valve": ["mesh.refine=0", "time.end=0.01"],
    "dfg-3d1z": ["mesh.extrude.layers=2", "mesh.extrude.grading=0"],
    "dfg-3d3z": ["mesh.extrude.layers=2", "mesh.extrude.grading=0", "time.step=0.01", "time.end=0.03"],
    "cook": [], "fsi-box": ["mesh.grading=0", "linear.solver=multifrontal"],
    "tube": [*TUBE, "mesh.cells=[10,4,1]", "time.end=3e-4"], "land": [],
}
TIGHT = ["newton.tolerance=1e-11", "linear.precision=double"]
# An iteration that needs no factors of the whole: blocks of the processes, ILU in each.
ITERATIVE = "-ksp_type fgmres -ksp_rtol 1e-3 -pc_type asm -pc_asm_overlap 0 -sub_pc_type ilu"


def start(program, case, sets, processes, threads=1):
    """A run; its columns, its rows and its summary."""
    environment = dict(os.environ, OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
    with tempfile.TemporaryDirectory() as out:
        command = [program, "run", case, "-o", out, "--force", "--quiet", "--threads", str(threads)]
        for item in ["output.fields-every=0", "output.report=false", *sets]:
            command += ["--set", item]
        if processes > 0:
            command = ["mpirun", "--oversubscribe", "-n", str(processes), *command, "--set", "linear.engine=petsc"]
        done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
        if done.returncode != 0:
            sys.exit(f"{case} on {processes} processes: exit code {done.returncode}\n{done.stderr}")
        with open(f"{out}/history.csv", encoding="utf-8") as file:
            rows = list(csv.reader(file))
        with open(f"{out}/summary.json", encoding="utf-8") as file:
            return rows[0], [[float(x) for x in row] for row in rows[1:]], json.load(file)


def gap(one, other):
    """The largest difference of a functional, relative to the largest value of it."""
    columns, rows, _ = one
    if len(rows) != len(other[1]):
        return float("inf")
    last = columns.index("min_J")
    worst = 0.0
    for n in range(3, last):
        largest = max(abs(row[n]) for row in rows) or 1.0
        worst = max([worst, *(abs(a[n] - b[n]) / largest for a, b in zip(rows, other[1]))])
    return worst


def same(program, cases):
    wrong = []
    print("| case | unknowns | defaults, 1 to 4 processes | `newton.tolerance=1e-11`, 1 to 4 processes |")
    print("| --- | --- | --- | --- |")
    for case in cases or CASES:
        cells = []
        for more, bound in [([], 1e-6), (TIGHT, 1e-9)]:
            sets = [*CASES[case], *more]
            one = start(program, case, sets, 0)
            gaps = [gap(one, start(program, case, sets, n)) for n in (1, 2, 3, 4)]
            wrong += [f"{case} {more}"] if max(gaps) > bound else []
            cells.append(" ".join(f"{x:.0e}" for x in gaps))
        print(f"| `{case}` | {one[2]['unknowns']['total']} | {cells[0]} | {cells[1]} |", flush=True)
    return wrong


def memory(program):
    return [*memory_by(program, f"linear.petsc.options={ITERATIVE}"), *memory_by(program, "linear.solver=multigrid")]


def memory_by(program, solver):
    sets = [*TUBE, "mesh.cells=[17,4,1]", "mesh.refine=2", "time.end=1e-4", "newton.tolerance=1e-4", solver]
    print(f"{solver}\n")
    print("| processes | cells | copies | MB before the mesh | peak MB |\n| --- | --- | --- | --- | --- |")
    one = start(program, "tube", sets, 1)[2]
    four = start(program, "tube", sets, 4)[2]["ranks"]
    base = max(rank["base_memory_bytes"] for rank in four)
    whole = one["peak_memory_bytes"] - base
    print(f"| 1 | {one['cells']} | | {base / 1e6:.0f} | {one['peak_memory_bytes'] / 1e6:.0f} |")
    for rank in four:
        print(f"| of 4 | {rank['cells']} | {rank['copies']} | {rank['base_memory_bytes'] / 1e6:.0f} | "
              f"{rank['peak_memory_bytes'] / 1e6:.0f} |")
    share = max(rank["peak_memory_bytes"] - rank["base_memory_bytes"] for rank in four) / whole
    print(f"\n{one['unknowns']['total']} unknowns, largest share of the memory {share:.3f}, asked 0.35")
    return [] if share <= 0.35 else [f"memory, {solver}"]


def counts(program):
    sets = [*TUBE, "mesh.cells=[40,8,1]", "time.end=3e-4"]
    print("| processes | cells | copies | neighbours | kB per exchange | exchanges per step |")
    print("| --- | --- | --- | --- | --- | --- |")
    for n in (2, 4, 8, 16):
        summary = start(program, "tube", sets, n)[2]
        ranks = summary["ranks"]
        of = lambda key: max(rank[key] for rank in ranks)
        # The condensed flow and the extension have an exchange for each correction.
        exchanges = 2 * summary["newton_steps"] / summary["steps"]
        messages = of("sent_messages") / (2 * summary["newton_steps"])
        each = of("sent_bytes") / (2 * summary["newton_steps"]) / 1e3
        print(f"| {n} | {of('cells')} | {of('copies')} | {messages:.0f} | {each:.0f} | {exchanges:.0f} |", flush=True)
    return []


def scaling(program):
    wrong = []
    print("| run | unknowns | two threads [s] | two processes [s] | speed |\n| --- | --- | --- | --- | --- |")
    for case, sets in [
        ("fsi3", ["mesh.refine=1", "time.end=0.25"]),
        ("tube", [*TUBE, "mesh.cells=[10,4,1]", "mesh.refine=1", "time.end=1e-3"]),
        ("fsi-box", ["mesh.grading=0"]),
        ("tube", [*TUBE, "mesh.cells=[12,8,1]", "mesh.refine=1", "time.end=5e-4", "linear.solver=multigrid"]),
    ]:
        times, unknowns = ([], []), 0
        for _ in range(3):
            for n, list_of in ((1, times[0]), (2, times[1])):
                summary = start(program, case, sets, n, threads=3 - n)[2]
                list_of.append(summary["wall_seconds"])
                unknowns = summary["unknowns"]["total"]
        one, two = map(statistics.median, times)
        wrong += [case] if one / two < 0.85 else []
        print(f"| `{case}` | {unknowns} | {one:.2f} | {two:.2f} | {one / two:.2f} |", flush=True)
    return wrong


def multigrid(program):
    wrong = []
    print("| unknowns | processes | Newton steps | iterations | difference | MB | seconds |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    for cells, refine, end in (("[12,8,1]", 1, "1e-3"), ("[6,4,1]", 2, "1e-3"), ("[17,4,1]", 2, "3e-4")):
        sets = [*TUBE, f"mesh.cells={cells}", f"mesh.refine={refine}", f"time.end={end}", "linear.solver=multigrid"]
        one = start(program, "tube", sets, 0)
        for n in (1, 2, 3, 4):
            found = one if n == 1 else start(program, "tube", sets, n)
            summary, far = found[2], gap(one, found)
            iterations, steps = summary["linear_iterations"], summary["newton_steps"]
            base = max((rank["base_memory_bytes"] for rank in summary.get("ranks", [])), default=0)
            memory = max((rank["peak_memory_bytes"] for rank in summary.get("ranks", [])),
                         default=summary["peak_memory_bytes"])
            seconds = f"{summary['wall_seconds']:.1f}" if n < 3 else ""
            bad = far > 1e-6 or summary["direct_fallbacks"] > 0
            wrong += [f"tube {cells} on {n}"] if bad else []
            print(f"| {summary['unknowns']['total']} | {n} | {steps} | {iterations} | {far:.0e} | "
                  f"{(memory - base) / 1e6:.0f} | {seconds} |", flush=True)
    return wrong


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    program, what = os.path.abspath(sys.argv[1]), sys.argv[2]
    tables = {"same": lambda: same(program, sys.argv[3:]), "memory": lambda: memory(program),
              "counts": lambda: counts(program), "scaling": lambda: scaling(program),
              "multigrid": lambda: multigrid(program)}
    wrong = tables[what]()
    if wrong:
        sys.exit(f"not met: {', '.join(wrong)}")


if __name__ == "__main__":
    main()
