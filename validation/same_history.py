#!/usr/bin/env python3
"""Compares history.csv of two programs byte for byte, for all built-in cases that both
have.

usage: validation/same_history.py OLD NEW [STEPS]        default 100 steps; stationary cases as a whole

Both programs run on one thread on this machine, one case after the other. The exit code is 1 if any file differs.
"""
import os, subprocess, sys, tempfile, tomllib

old, new = (os.path.abspath(program) for program in sys.argv[1:3])
steps = int(sys.argv[3]) if len(sys.argv) > 3 else 100


def said(program, *words):
    return subprocess.run([program, *words], check=True, capture_output=True, text=True).stdout


def history(program, case, sets, directory):
    words = [word for value in sets for word in ("--set", value)]
    command = [program, "run", case, *words, "--threads", "1", "--quiet", "--force", "-o", directory]
    subprocess.run(command, check=True, capture_output=True)
    return open(os.path.join(directory, "history.csv"), "rb").read()


def names(program):
    return [line.split()[0] for line in said(program, "cases").splitlines() if line.strip()]


cases = [case for case in names(new) if case in names(old)]
different = 0
with tempfile.TemporaryDirectory(prefix="undula-same-") as work:
    for case in cases:
        time = tomllib.loads(said(new, "check", case, "--toml")).get("time", {})
        sets = [f"time.end={time.get('start', 0.0) + steps * time['step']}"] if "step" in time else []
        rows = [history(program, case, sets, os.path.join(work, name)) for program, name in ((old, "old"), (new, "new"))]
        same = rows[0] == rows[1]
        different += not same
        count = rows[1].count(b"\n") - 1
        print(f"{case:10s} {count:5d} rows  {'equal' if same else 'DIFFERENT'}", flush=True)
sys.exit(different > 0)
