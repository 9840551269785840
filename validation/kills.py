#!/usr/bin/env python3
"""Kills and interrupts a run again and again, resumes it each time, and compares with a run that was left alone.

usage: validation/kills.py PROGRAM [KILLS] [SEED]        100 kills in /tmp or $TMPDIR, about five minutes

Rows, fields, their list, and the arrays of the last checkpoint must have the same bytes.
"""
import collections, os, random, signal, subprocess, sys, tempfile, time

from bits import differing

program = os.path.abspath(sys.argv[1])
kills = int(sys.argv[2]) if len(sys.argv) > 2 else 100
random.seed(int(sys.argv[3]) if len(sys.argv) > 3 else 1)
SETS = ["mesh.refine=0", "time.step=0.01", "solid.body-force=[0,-2]", "output.checkpoint-every=7",
        "output.checkpoint-minutes=0.002", "output.fields-every=5", "output.fields-interval=0.024"]


def command(directory, end, *flags):
    sets = [word for value in SETS + [f"time.end={end}"] for word in ("--set", value)]
    return [program, "run", "fsi3", *sets, "--threads", "1", "--quiet", "-o", directory, *flags]


work = tempfile.mkdtemp(prefix="undula-kills-")
os.chdir(work)
begun = time.time()
subprocess.run(command("pace", 0.5), check=True)
pace = (time.time() - begun) / 50
steps = max(200, int(1.5 * kills))
end = round(0.01 * steps, 6)
subprocess.run(command("whole", end), check=True)
counts, done = collections.Counter(), False
while sum(counts[name] for name in ("SIGKILL", "SIGINT", "SIGTERM")) < kills:
    # Now and then to an earlier end, on the grid of the steps or not: then it is extended.
    goal = end if random.random() < 0.9 else round(end * random.random(), random.choice([2, 4]))
    flags = ("--resume",) if os.path.exists("parts/history.csv") else ("--force",)
    child = subprocess.Popen(command("parts", goal, *flags), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    time.sleep(random.uniform(0.0, 14 * pace + 0.1))
    what = random.choices(["SIGKILL", "SIGINT", "SIGTERM"], [6, 2, 1])[0]
    ended = child.poll() is not None
    if not ended:
        child.send_signal(getattr(signal, what))
    said = child.communicate()[1]
    code = child.returncode
    if not ended and code != 0:
        counts[what] += 1
    refused = [words for words in ("already completed", "lies before it", "holds none", "case.toml is missing") if words in said]
    expected = {0: True, -9: what == "SIGKILL", 130: what != "SIGKILL", 2: bool(refused)}.get(code, False)
    if not expected:
        sys.exit(f"code {code} after {what}: {said}")
    if code == 2:
        counts["refused: " + refused[0]] += 1
        if refused[0] in ("holds none", "case.toml is missing"):
            # Killed before its first checkpoint.
            subprocess.run(["rm", "-r", "parts"], check=True)
    if "already completed" in said and goal == end:
        subprocess.run(["rm", "-r", "parts"], check=True)
        counts["begun anew"] += 1
child = subprocess.run(command("parts", end, "--resume"), capture_output=True, text=True)
if child.returncode == 2 and ("holds none" in child.stderr or "missing" in child.stderr):
    child = subprocess.run(command("parts", end, "--force"), capture_output=True, text=True)
if child.returncode != 0 and "already completed" not in child.stderr:
    sys.exit(f"the last resume: code {child.returncode}: {child.stderr}")
differ, compared = differing("whole", "parts")
print(dict(counts), f"{steps} steps, {compared} files and arrays compared, {time.time() - begun:.0f} s")
sys.exit(f"they differ: {differ}; see {work}" if differ else 0)
