#!/usr/bin/env bash
# Licences, duplicates, advisories and sources of what the program depends on: by cargo-deny where it is installed
# (cargo install --locked cargo-deny), else as far as a test can tell.
set -euo pipefail
cd "$(dirname "$0")/.."

if cargo deny --version >/dev/null 2>&1; then
    cargo deny check
else
    echo "cargo-deny is missing: licences and duplicates are checked, advisories are NOT CHECKED"
    cargo test --quiet --test dependencies
fi
