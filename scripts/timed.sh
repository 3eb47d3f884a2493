#!/usr/bin/env bash
# Runs a test binary so that it prints the time of each test: `CARGO_TARGET_<HOST>_RUNNER=scripts/timed.sh cargo test`.
# The flag is not stable; should it go away, tests run without times.
case "$1" in
    */deps/*)
        if RUSTC_BOOTSTRAP=1 "$1" -Zunstable-options --report-time --list >/dev/null 2>&1; then
            program=$1
            shift
            export RUSTC_BOOTSTRAP=1
            exec "$program" -Zunstable-options --report-time "$@"
        fi
        ;;
esac
exec "$@"
