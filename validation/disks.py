#!/usr/bin/env python3
"""A disk that is full, a limit on files, a directory that is removed: the run ends with a sentence, and can go on.

usage: validation/disks.py PROGRAM [TIMES] [SEED]        20 times each in /tmp or $TMPDIR, about five minutes

A small file system in memory needs the right to mount it; without it that part is left out, with a word. Each time the disk
fills at another moment. The run must end with exit code 1 and name the file and the reason; with room again `--resume`
completes it (where no checkpoint was written: `--force`), with the bytes of a run that was left alone.
"""
import collections, os, random, resource, shutil, signal, subprocess, sys, tempfile, time

from bits import differing

program = os.path.abspath(sys.argv[1])
times = int(sys.argv[2]) if len(sys.argv) > 2 else 20
random.seed(int(sys.argv[3]) if len(sys.argv) > 3 else 1)
SETS = ["mesh.refine=0", "time.step=0.01", "time.end=1", "solid.body-force=[0,-2]", "output.checkpoint-every=10",
        "output.fields-every=5"]
WORDS = [word for value in SETS for word in ("--set", value)]
work = tempfile.mkdtemp(prefix="undula-disks-")
os.chdir(work)
counts, begun = collections.Counter(), time.time()


def run(directory, *flags, limit=None, told=True):
    def limited():
        # A signal comes with a write beyond the limit, which ends the program unless whoever starts it has it ignored.
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN if told else signal.SIG_DFL)
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    command = [program, "run", "fsi3", *WORDS, "--threads", "1", "--quiet", "-o", directory, *flags]
    return subprocess.run(command, capture_output=True, text=True, preexec_fn=limited if limit else None, restore_signals=False)


def goes_on(directory, kind):
    """Completes the run and compares it."""
    child = run(directory, "--resume")
    if child.returncode == 2:
        counts[kind + ": no checkpoint, begun anew"] += 1
        child = run(directory, "--force")
    if child.returncode != 0:
        sys.exit(f"{kind}: cannot go on: code {child.returncode}: {child.stderr}")
    differ, _ = differing("whole", directory)
    if differ:
        sys.exit(f"{kind}: they differ: {differ}; see {work}")
    counts[kind + ": completed with the same bytes"] += 1
    shutil.rmtree(directory)


def told(child, kind, words):
    if child.returncode != 1 or not any(word in child.stderr for word in words):
        sys.exit(f"{kind}: code {child.returncode}: {child.stderr}{child.stdout}")
    said = child.stderr.strip().splitlines()[-1]
    place = [name for name in ("history.csv", "checkpoint", ".vtu", "fields.pvd", "summary.json", "case.toml") if name in said]
    counts[f"{kind}: told of {place[0] if place else said[:80]}"] += 1


def size_of(directory):
    return sum(os.path.getsize(os.path.join(folder, name)) for folder, _, names in os.walk(directory) for name in names)


assert run("whole").returncode == 0
whole = size_of("whole")
os.mkdir("small")
mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={2 * whole}", "tmpfs", "small"], capture_output=True)
if mounted.returncode == 0:
    try:
        for _ in range(times):
            with open("small/filler", "wb") as filler:
                filler.write(bytes(2 * whole - int(whole * random.uniform(0.0, 0.95))))
            child = run("small/run", "--force")
            if child.returncode == 0:
                counts["disk full: there was room"] += 1
                shutil.rmtree("small/run")
                continue
            told(child, "disk full", ["No space left"])
            os.remove("small/filler")
            goes_on("small/run", "disk full") if os.path.exists("small/run/history.csv") else None
            shutil.rmtree("small/run", ignore_errors=True)
    finally:
        subprocess.run(["umount", "small"])
else:
    print("disk full: left out, nothing can be mounted here:", mounted.stderr.decode().strip())
largest = max(os.path.getsize(os.path.join(folder, name)) for folder, _, names in os.walk("whole") for name in names)
for _ in range(times):
    limit = random.randrange(2000, largest)
    child = run("parts", "--force", limit=limit, told=False)
    if child.returncode != -signal.SIGXFSZ:
        sys.exit(f"file-size limit: code {child.returncode}: {child.stderr}")
    goes_on("parts", "ended by SIGXFSZ") if os.path.exists("parts/history.csv") else counts.update(["ended by SIGXFSZ: before a row"])
    shutil.rmtree("parts", ignore_errors=True)
    child = run("parts", "--force", limit=limit)
    told(child, "file-size limit", ["File too large"])
    goes_on("parts", "file-size limit") if os.path.exists("parts/history.csv") else counts.update(["file-size limit: before a row"])
    shutil.rmtree("parts", ignore_errors=True)
pace = time.time()
run("parts", "--force")
pace = time.time() - pace
for _ in range(times):
    command = [program, "run", "fsi3", *WORDS, "--threads", "1", "--quiet", "--force", "-o", "gone", "--set", "time.end=60"]
    child = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    while not os.path.exists("gone/history.csv"):
        time.sleep(0.005)
    time.sleep(random.uniform(0, pace))
    # At once, or file by file: then a run that misses its history first may write it again into what is left.
    how = random.choice(["moved away", "removed"])
    if how == "moved away":
        os.rename("gone", "elsewhere")
        shutil.rmtree("elsewhere")
    while os.path.exists("gone"):
        shutil.rmtree("gone", ignore_errors=True)
    asked = time.time()
    said = child.communicate()[1]
    if child.returncode != 1 or "gone" not in said or (how == "moved away" and os.path.exists("gone")):
        sys.exit(f"directory {how}: code {child.returncode}: {said}")
    counts[f"directory {how}: told" + (", something was written meanwhile" if os.path.exists("gone") else "")] += 1
    shutil.rmtree("gone", ignore_errors=True)
    counts["seconds until the end, at most"] = max(counts["seconds until the end, at most"], round(time.time() - asked, 1))
for name, count in counts.items():
    print(f"{name}: {count}")
print(f"{time.time() - begun:.0f} s")
shutil.rmtree(work)
