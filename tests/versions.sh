#!/usr/bin/env bash
# Tries the bounds in pyproject.toml, each in a fresh virtual environment; needs `uv`.
#
#   tests/versions.sh oldest [PYTHON]    every dependency at its lower bound; the quick part of the tests
#   tests/versions.sh newest [PYTHON]    every dependency at its newest; the same
#   tests/versions.sh beside [PYTHON]    that the wheel can be installed beside other packages at their newest (resolved, not installed)
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

QUICK="tests/physics/model tests/physics/engines tests/lanes tests/recordings tests/estimation tests/search tests/api
       tests/replay tests/runs tests/cli/test_main.py tests/cli/test_check.py tests/test_docs.py tests/test_package_data.py"
BESIDE="lerobot mjlab genesis-world gymnasium torch"
end="${1:?oldest, newest or beside}"
case "$end" in oldest) python="${2:-3.11}" ;; *) python="${2:-3.12}" ;; esac
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT

quick() { # in the environment made by the caller
    # shellcheck disable=SC2086
    "$folder/venv/bin/python" -m pytest -q -n 2 --dist worksteal $QUICK
}

case "$end" in
oldest)
    uv venv -q --python "$python" "$folder/venv"
    "$folder/venv/bin/python" -c '
import re, tomllib
for line in tomllib.load(open("pyproject.toml", "rb"))["project"]["dependencies"]:
    print(re.sub(r">=([^,]*),.*", r"==\1", line))' > "$folder/oldest.txt"
    uv pip install -q --python "$folder/venv/bin/python" --constraint "$folder/oldest.txt" -e '.[dev]'
    quick
    ;;
newest)
    uv venv -q --python "$python" "$folder/venv"
    uv pip install -q --python "$folder/venv/bin/python" -e '.[dev]'
    quick
    ;;
beside)
    for other in $BESIDE "$BESIDE"; do
        # shellcheck disable=SC2086
        printf '%s\n' $other > "$folder/in.txt"
        uv pip compile -q --python-version "$python" "$folder/in.txt" --no-header -o "$folder/alone.txt"
        # They stay at the versions that they would have without this package.
        for name in $other; do grep -iE "^$name==" "$folder/alone.txt"; done > "$folder/kept.txt"
        rm -f "$folder/both.txt" # uv would hold to what is in it
        uv pip compile -q --python-version "$python" pyproject.toml "$folder/kept.txt" --no-header -o "$folder/both.txt"
        echo "beside $(paste -sd' ' "$folder/kept.txt"): $(grep -E '^(mujoco|mujoco-mjx|jax|numpy|pillow)==' "$folder/both.txt" | paste -sd' ')"
    done
    ;;
*)
    echo "oldest, newest or beside" >&2
    exit 2
    ;;
esac
