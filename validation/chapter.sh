#!/usr/bin/env bash
# The numerical studies of chapter 5 at full length: page, verdicts and small tables to validation/chapter.
#
#   validation/chapter.sh            about two hours on two cores; goes on where it was interrupted
#   validation/chapter.sh --collect  only copy from out/chapter-5, or from the directory in CHAPTER
set -euo pipefail
cd "$(dirname "$0")/.."

from=${CHAPTER:-out/chapter-5}
if [ "${1:-}" != --collect ]; then
    cargo run --release -- reproduce -o "$from"
fi
to=validation/chapter
rm -rf "$to"
mkdir -p "$to"
cp "$from/index.html" "$from/results.json" "$to"
# Tables; signals of figures are large, and pictures are in the page.
for study in "$from"/*/; do
    name=$(basename "$study")
    mkdir -p "$to/$name"
    find "$study" -maxdepth 1 -name '*.csv' -size -100k -exec cp {} "$to/$name" \;
done
python3 - "$to" <<'PYTHON'
"""Writes README.md from results.json."""
import json
import os
import subprocess
import sys
import textwrap
import time

to = sys.argv[1]
studies = json.load(open(f"{to}/results.json"))
cpus = subprocess.run(["lscpu"], capture_output=True, text=True, check=True).stdout.splitlines()
model = next((line.split(":")[1].strip() for line in cpus if line.startswith("Model name")), "unknown processor")
date = time.strftime("%Y-%m-%d", time.gmtime(os.path.getmtime(f"{to}/results.json")))
lines = [
    "# The studies of chapter 5",
    "",
    f"{date}, {model}, {os.cpu_count()} cores, shared with other work. Each run has its commit in `runs.csv`.",
    "",
    "Written by `validation/chapter.sh`, which runs `undula reproduce`. [index.html](index.html) is the page: download it",
    "and open it in a browser. CSV files of long signals are left out here; `undula reproduce` writes them.",
    "",
    "| study | statements | reproduced | not | undecided | runs (min) |",
    "| --- | --- | --- | --- | --- | --- |",
]
total = [0, 0, 0, 0, 0.0]
for study in studies:
    verdicts = [s["verdict"] for s in study["statements"]]
    counts = [len(verdicts)] + [verdicts.count(v) for v in ("reproduced", "not reproduced", "undecided")]
    row = counts + [study["seconds"] / 60]
    total = [a + b for a, b in zip(total, row)]
    lines.append(f"| {study['study']} ({study['section']}) | " + " | ".join(map(str, counts)) + f" | {row[4]:.1f} |")
lines.append("| all | " + " | ".join(map(str, total[:4])) + f" | {total[4]:.1f} |")
lines += ["", "Minutes are those of all runs added up; two run at a time.", "", "## Not reproduced", ""]
for study in studies:
    for s in study["statements"]:
        if s["verdict"] != "reproduced":
            number = "" if s["number"] is None else f" (computed {s['number']:.4g} {s['unit']})".replace(" )", ")")
            text = f"- {study['study']}, {s['section']}: {s['text'].strip()}{number} *{s['verdict']}*"
            if s.get("because"):
                text += f". {s['because'].strip()}"
            lines.append(textwrap.fill(text, 118, subsequent_indent="  "))
open(f"{to}/README.md", "w").write("\n".join(lines) + "\n")
PYTHON
