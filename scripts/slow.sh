#!/usr/bin/env bash
# The slow group: what takes minutes or needs more than Rust. `--list` names its parts, a name runs one.
set -euo pipefail
cd "$(dirname "$0")/.."

# Installs a Debian package where that is possible; whoever cannot is told.
need() {
    command -v "$1" >/dev/null && return
    echo "$1 is missing, trying to install it"
    { apt-get update && apt-get install --yes "$2"; } >/dev/null 2>&1 || true
    command -v "$1" >/dev/null
}

browser() {
    if ! need chromium chromium || ! command -v npm >/dev/null ||
        ! (cd tests/browser && npm ci --no-audit --no-fund --silent); then
        echo "NOT CHECKED: the pages need Chromium, Node.js and the packages of tests/browser (apt-get install chromium nodejs npm)"
        return
    fi
    cargo build
    (cd tests/browser && LACUNA="$OLDPWD/target/debug/lacuna" node --test --test-concurrency=1 "$@")
}

case "${1:-}" in
    --list) printf '%s\n' report nlopt workbench workbench-data examination ;;
    report) browser report.test.mjs ;;
    workbench) browser workbench.test.mjs workbench_looks.test.mjs ;;
    workbench-data) browser workbench_data.test.mjs workbench_scripts.test.mjs ;;
    speed) browser speed.test.mjs ;;
    examination) cargo run --quiet -- benchmark --part small --quiet ;;
    nlopt)
        if need cmake cmake; then
            cargo clippy --features nlopt -- -D warnings
            cargo test --features nlopt --test nlopt
            cargo run --features nlopt -- scenario scenarios/panda_nlopt.ron
        else
            echo "NOT CHECKED: the feature nlopt needs CMake (apt-get install cmake g++)"
        fi
        ;;
    fuzz) LACUNA_SLOW=1 cargo test --test fuzz ;;
    *) echo "parts: $(bash "$0" --list | tr '\n' ' ')and by name alone: speed fuzz"; exit 2 ;;
esac
