#!/usr/bin/env python3
"""Tables, Richardson values and histories of the references from the runs of validation/references/run.sh.

usage: validation/references/evaluate.py DIR [--write]      --write: README.md and CSV files beside this script

Of each value x on three meshes, x0, x1 and x2, the ratio q = (x2 - x1)/(x1 - x0) gives x2 + (x2 - x1) q/(1 - q) where
0 < q < 1/2 (Richardson's extrapolation with the order that is observed); else x2 stays. A run with half the time step on
the middle mesh gives the error of the step, with the order p of the scheme: (xk - x1) 2^p/(2^p - 1) is added. The
uncertainty is the sum of 1.25 times what is left after Roache (1994): |x2 - x1| q/(1 - q), q between 1/4 and 1/2, and
|xk - x1|/(2^p - 1), and of what the harmonics leave of the samples.
"""
import csv, os, sys, time
import numpy

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.dirname(HERE))
import periodic

RUNS = {"0": "Q4, `refine=0`", "1": "Q4, `refine=1`", "2": "Q4, `refine=2`", "q3": "Q3, `refine=2`", "k": "Q4, `refine=1`"}
TITLES = {"drag": "drag", "lift": "lift", "ux_A": "u_x of A", "uy_A": "u_y of A", "frequency": "frequency"}
# Those at the end of a run; fsi2 takes longer to become periodic, and has long periods.
PERIODS = {"fsi3": 6, "fsi2": 3, "cfd3": 6}
UNITS = {"drag": "N/m", "lift": "N/m", "ux_A": "mm", "uy_A": "mm", "frequency": "Hz"}
# Mean and amplitude of featflow (Turek and Hron 2006, Turek and others 2010), finest mesh and smallest step.
FEATFLOW = {
    "fsi3": {"drag": (460.5, 27.74), "lift": (2.50, 153.91), "ux_A": (-2.88, 2.72), "uy_A": (1.47, 34.99), "frequency": (5.46,)},
    "fsi2": {"drag": (215.06, 77.65), "lift": (0.61, 237.8), "ux_A": (-14.85, 12.70), "uy_A": (1.30, 81.6), "frequency": (1.93,)},
    "cfd3": {"drag": (439.45, 5.6183), "lift": (-11.893, 437.81), "frequency": (4.3956,)},
    "csm3": {"ux_A": (-14.305, 14.305), "uy_A": (-63.607, 65.160), "frequency": (1.0995,)},
}


def extremes(times, values):
    """Smallest and largest value, by parabolas through three samples."""
    found = []
    for sign in (-1, 1):
        signed = sign * values
        at = 1 + numpy.argmax(signed[1:-1])
        below, middle, above = signed[at - 1 : at + 2]
        slope, bend = (above - below) / 2, above - 2 * middle + below
        found.append(sign * (middle - slope**2 / (2 * bend) if bend < 0 else middle))
    return found


def vibrating(directory):
    """A vibration from rest, in the whole time: it has other frequencies besides, so that no period is like the last."""
    with open(os.path.join(directory, "history.csv")) as file:
        rows = list(csv.DictReader(file))
    column = lambda name: numpy.array([float(row[name]) for row in rows])
    values, times = {}, column("time")
    for name in ("ux_A", "uy_A"):
        low, high = (1e3 * value for value in extremes(times, column(name)))
        values[name] = ((high + low) / 2, (high - low) / 2, 0.0)
    # From the first to the last time at which u_y sinks through its middle.
    uy, middle = 1e3 * column("uy_A"), values["uy_A"][0]
    down = numpy.nonzero((uy[:-1] > middle) & (uy[1:] <= middle))[0]
    crossings = times[down] + (middle - uy[down]) / (uy[down + 1] - uy[down]) * (times[down + 1] - times[down])
    values["frequency"] = ((len(crossings) - 1) / (crossings[-1] - crossings[0]), 0.0)
    with open(os.path.join(directory, "summary.json")) as file:
        return values, periodic.json.load(file)


def read(case, directory):
    """(mean, amplitude, fit) of each quantity, (frequency, fit), and the summary of the run."""
    if case == "csm3":
        return vibrating(directory)
    found = periodic.periodic(directory, PERIODS[case])
    values = {name: (q["mean"], q["amplitude"], q["fit"]) for name, q in found["quantities"].items()}
    values["frequency"] = (found["frequency"], 0.0)
    return values, found["summary"]


def is_completed(directory):
    try:
        with open(os.path.join(directory, "summary.json")) as file:
            return periodic.json.load(file)["status"] == "completed"
    except FileNotFoundError:
        return False


def reference(name, at, found):
    """Value and uncertainty of mean (at = 0) or amplitude (at = 1) from the runs 0, 1, 2 and k."""
    x0, x1, x2, xk = (found[run][0][name][at] for run in "012k")
    ratio = (x2 - x1) / (x1 - x0)
    value = x2 + ((x2 - x1) * ratio / (1 - ratio) if 0 < ratio < 0.5 else 0.0)
    bounded = min(max(abs(ratio), 0.25), 0.5)
    order = 2 if name in ("drag", "lift") or "csm3" in found["case"] else 3
    step = (xk - x1) / (2**order - 1)
    left = 1.25 * (abs(x2 - x1) * bounded / (1 - bounded) + abs(step)) + found["2"][0][name][-1]
    return value + step * 2**order, left


def rounded(value, uncertainty):
    """As many digits as the uncertainty leaves: two of its own."""
    digits = max(0, 1 - int(numpy.floor(numpy.log10(uncertainty)))) if uncertainty > 0 else 6
    return f"{value:.{digits}f}".replace("-", "−"), f"{uncertainty:.{digits}f}"


def cells(values, name):
    if name == "frequency":
        return f"{values[name][0]:.4f}"
    digits = 2 if UNITS[name] == "N/m" else 3
    mean, amplitude = values[name][:2]
    return f"{mean:.{digits}f} ± {amplitude:.{digits}f}".replace("-", "−")


def section(case, directory):
    found, lines = {"case": case}, [f"## {case}", ""]
    for run in RUNS:
        path = os.path.join(directory, f"{case}-{run}")
        if is_completed(path):
            found[run] = read(case, path)
    names = list(found["1"][0])
    lines += ["| elements | unknowns | k (s) | " + " | ".join(f"{TITLES[n]} ({UNITS[n]})" for n in names) + " | min |"]
    lines += ["| --- " * (len(names) + 4) + "|"]
    for run, elements in RUNS.items():
        if run in found:
            values, summary = found[run]
            cell = " | ".join(cells(values, name) for name in names)
            step = step_of(os.path.join(directory, f"{case}-{run}"))
            minutes = summary["wall_seconds"] / 60
            lines += [f"| {elements} | {summary['unknowns']['total']} | {step:g} | {cell} | {minutes:.1f} |"]
    lines += ["", "| | value | uncertainty | featflow | difference |", "| --- | --- | --- | --- | --- |"]
    for name in names:
        for at, kind in enumerate(("mean", "amplitude") if name != "frequency" else ("",)):
            value, left = reference(name, at, found)
            theirs = FEATFLOW[case][name][at]
            words = rounded(value, left)
            title = f"{TITLES[name]}{', ' + kind if kind else ''} ({UNITS[name]})"
            difference = f"{100 * (theirs / value - 1):+.2f} %".replace("-", "−")
            lines += [f"| {title} | {words[0]} | {words[1]} | {theirs:g} | {difference} |".replace("| -", "| −")]
    return lines + [""]


def step_of(directory):
    with open(os.path.join(directory, "history.csv")) as file:
        rows = list(csv.DictReader(file))
    return float(f"{float(rows[-2]['time']) - float(rows[-3]['time']):.3g}")


def history(case, directory):
    """CSV of the finest run: one period from the time at which the leading quantity grows past its mean."""
    path = os.path.join(HERE, f"{case}.csv")
    with open(path, "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        if case == "csm3":
            with open(os.path.join(directory, f"{case}-2", "history.csv")) as source:
                rows = list(csv.DictReader(source))
            writer.writerow(["time", "ux_A", "uy_A"])
            writer.writerows([row[n] for n in ("time", "ux_A", "uy_A")] for row in rows[7::8])
        else:
            values = periodic.periodic(os.path.join(directory, f"{case}-2"), PERIODS[case])["values"]
            writer.writerow(["phase", *values])
            for at in range(0, 2000, 10):
                scaled = (values[name][at] / periodic.UNITS[name] for name in values)
                writer.writerow([f"{at / 2000:.3f}", *(f"{value:.6g}" for value in scaled)])


def main():
    directory, write = sys.argv[1], "--write" in sys.argv
    lines = []
    for case in ("fsi3", "fsi2", "cfd3", "csm3"):
        missing = [run for run in "012k" if not is_completed(os.path.join(directory, f"{case}-{run}"))]
        if missing:
            print(f"{case}: {', '.join(missing)} not there", file=sys.stderr)
            continue
        lines += section(case, directory)
        if write:
            history(case, directory)
    text = "\n".join(lines)
    print(text)
    if write:
        path = os.path.join(HERE, "README.md")
        with open(path) as file:
            head = file.read().split("\n## fsi3\n")[0]
        with open(path, "w") as file:
            file.write(f"{head}\n{text}")


main()
