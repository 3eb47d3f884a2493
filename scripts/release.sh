#!/usr/bin/env bash
# Builds the program for others: in the profile `dist`, and without the paths of this machine, which panic messages
# carry otherwise. Further arguments go to cargo (--target, --features).
set -euo pipefail
cd "$(dirname "$0")/.."

here=$(pwd -P)
home=$(cd "${CARGO_HOME:-$HOME/.cargo}" && pwd -P)
sysroot=$(rustc --print sysroot)
# The last that fits wins: the longer ones come last.
flags=("--remap-path-prefix=$HOME=~" "--remap-path-prefix=$home=cargo" "--remap-path-prefix=$sysroot=rust"
       "--remap-path-prefix=$here=lacuna")
for registry in "$home"/registry/src/*/; do
    [ -d "$registry" ] && flags+=("--remap-path-prefix=${registry%/}=crates")
done
CARGO_ENCODED_RUSTFLAGS=$(IFS=$'\x1f'; echo "${flags[*]}")
export CARGO_ENCODED_RUSTFLAGS
cargo build --profile dist --locked "$@"

target=${CARGO_TARGET_DIR:-target}
found=0
for program in "$target"/dist/lacuna "$target"/*/dist/lacuna; do
    [ -f "$program" ] || continue
    found=1
    for path in "$HOME/" "$home" "$sysroot" "$here"; do
        if grep --quiet --text --fixed-strings -- "$path" "$program"; then
            echo "$program holds the path $path of this machine"
            exit 1
        fi
    done
    echo "$program: no path of this machine is in it"
done
[ "$found" = 1 ] || { echo "no program was built"; exit 1; }
