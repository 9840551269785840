#!/usr/bin/env python3
"""Four programs start runs in one directory, again and again: one computes, the others are told so.

usage: validation/starters.py PROGRAM [SECONDS]          default 120 s, in /tmp or $TMPDIR

Exit code 0 or 2 (`another run is writing`) only, and every file of the last run is whole.
"""
import collections, os, subprocess, sys, tempfile, threading, time

program = os.path.abspath(sys.argv[1])
seconds = float(sys.argv[2]) if len(sys.argv) > 2 else 120.0
sets = ["mesh.refine=0", "time.end=0.02", "output.fields-every=1", "output.checkpoint-every=1"]
words = [word for value in sets for word in ("--set", value)]
command = [program, "run", "fsi3", *words, "--threads", "1", "-q", "--force", "-o", "race"]
os.chdir(tempfile.mkdtemp(prefix="undula-starters-"))
counts, begun = collections.Counter(), time.time()


def start():
    while time.time() - begun < seconds:
        done = subprocess.run(command, capture_output=True, text=True)
        counts[(done.returncode, done.stderr.strip()[:150])] += 1


threads = [threading.Thread(target=start) for _ in range(4)]
[thread.start() for thread in threads]
[thread.join() for thread in threads]
for (code, said), count in counts.most_common():
    print(count, code, said)
wrong = [key for key in counts if key[0] != 0 and not (key[0] == 2 and "another run is writing" in key[1])]
rows = open("race/history.csv").read().splitlines()
whole = len(rows) == 5 and len(os.listdir("race/fields")) == 5 and not os.path.exists("race/.lock")
sys.exit(f"wrong endings: {wrong}" if wrong else 0 if whole else "the last run is not whole")
