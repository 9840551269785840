#!/usr/bin/env bash
# Builds the wheel of the Python module, installs it into an empty environment, and runs its tests there, and the
# Python lines of README.md and docs/python.md:  validation/python.sh [--profile dev --features undula/narrow]
#
# The options are those of `maturin build` (default: --release). It needs Python 3.10, and the network for maturin, numpy and pytest;
# without them it says so and ends well. WHEELS=DIR keeps the wheel.
set -euo pipefail
cd "$(dirname "$0")/.."
options=("${@:---release}")
skip() {
    printf 'skipped: the Python module (%s)\n' "$1"
    exit 0
}

python3 -c 'import sys, venv; sys.exit(sys.version_info < (3, 10))' 2>/dev/null || skip "there is no Python 3.10"
place=$(mktemp -d)
trap 'rm -r "$place"' EXIT
python3 -m venv "$place/build" 2>/dev/null || skip "Python makes no environments"
"$place/build/bin/pip" install --quiet --disable-pip-version-check 'maturin>=1.9,<2' || skip "no maturin, or no network"
wheels=${WHEELS:-$place/wheels}
"$place/build/bin/maturin" build --locked "${options[@]}" --manifest-path crates/undula-py/Cargo.toml --out "$wheels"

# As on a machine without Rust.
python3 -m venv "$place/empty"
"$place/empty/bin/pip" install --quiet --disable-pip-version-check "$wheels"/undula-*.whl pytest
(
    cd "$place"
    PATH="$place/empty/bin:/usr/bin:/bin" "$place/empty/bin/python" -m pytest -q -p no:cacheprovider \
        "$OLDPWD/crates/undula-py/tests"
)
"$place/empty/bin/python" validation/python_lines.py "$place/work" README.md docs/python.md
