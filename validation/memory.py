#!/usr/bin/env python3
"""Memory of a long run over its time: does it grow?

usage: validation/memory.py PROGRAM [REFINE] [END] [SETTINGS...]        fsi3, by default mesh.refine=0 to 100 s

Prints the resident memory at forty times and the largest so far. Linux only.
"""
import os, shutil, subprocess, sys, tempfile, time

program = os.path.abspath(sys.argv[1])
refine = sys.argv[2] if len(sys.argv) > 2 else "0"
end = float(sys.argv[3]) if len(sys.argv) > 3 else 100.0
work = tempfile.mkdtemp(prefix="undula-memory-")
command = [program, "run", "fsi3", "--threads", "1", "-q", "-o", work + "/run", "--set", f"mesh.refine={refine}", "--set", f"time.end={end}"]
run = subprocess.Popen(command + [word for setting in sys.argv[4:] for word in ("--set", setting)])
last = 0.0
while run.poll() is None:
    time.sleep(0.05)
    try:
        with open(f"/proc/{run.pid}/status") as file:
            kilobytes = {line.split(":")[0]: int(line.split()[1]) for line in file if line.startswith(("VmRSS", "VmHWM"))}
        with open(work + "/run/history.csv", "rb") as file:
            file.seek(max(0, os.path.getsize(file.name) - 2000))
            now = float(file.read().decode().splitlines()[-1].split(",")[1])
    except (OSError, ValueError, IndexError):
        continue
    if now - last >= end / 40 and kilobytes:
        print(f"t = {now:8.3f} s: {kilobytes['VmRSS'] / 1000:.2f} MB, at most {kilobytes['VmHWM'] / 1000:.2f} MB", flush=True)
        last = now
shutil.rmtree(work)
sys.exit(run.wait())
