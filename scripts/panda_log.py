#!/usr/bin/env python3
"""Turns the public Panda log of Gaz et al. 2019 into a CSV that lacuna reads.

The log lies in the authors' repository as headerless text files, one number per line:
times, and seven positions, velocities and torques per sample. Get it and convert it with

    git clone https://github.com/marcocognetti/FrankaEmikaPandaDynModel
    python3 scripts/panda_log.py FrankaEmikaPandaDynModel panda.csv

The numbers are copied as they are written, so nothing is rounded. The data stay under the licence
of that repository (GPL-3.0); keep them out of packages under another one. A name that ends in `.gz`
gives a packed file. Needs nothing but Python 3.
"""

import argparse
import gzip
import pathlib
import sys

JOINTS = 7
FOLDER = pathlib.Path("matlab/data/Exciting_Traj/Trajectory_1/rbt_log")
FILES = {
    "t": "exciting_traj_time.txt",  # [s], stamp of the reading computer
    "q": "exciting_traj_positions.txt",  # [rad]
    "dq": "exciting_traj_velocity.txt",  # [rad/s]
    "tau": "exciting_traj_torques.txt",  # [N m], link side, gravity included
}


def numbers(path):
    """The number texts of a file; an error that names file and line if one is none."""
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        sys.exit(f"{path}: {error.strerror}\n  help: give the folder of the cloned repository")
    found = []
    for at, line in enumerate(text.splitlines(), start=1):
        for field in line.split():
            try:
                float(field)
            except ValueError:
                sys.exit(f"{path}:{at}: `{field[:40]}` is not a number\n  help: clone the repository again")
            found.append(field)
    return found


def rows(folder):
    """The header, then one list of number texts per sample."""
    columns = {name: numbers(folder / file) for name, file in FILES.items()}
    samples = len(columns["t"])
    yield ["t"] + [f"{name}{j}" for name in FILES if name != "t" for j in range(1, JOINTS + 1)]
    for name, file in FILES.items():
        expected = samples * (1 if name == "t" else JOINTS)
        if len(columns[name]) != expected:
            sys.exit(f"{folder / file}: {len(columns[name])} numbers, expected {expected} for {samples} samples")
    for k in range(samples):
        row = [columns["t"][k]]
        for name in FILES:
            if name != "t":
                row += columns[name][k * JOINTS : (k + 1) * JOINTS]
        yield row


def main():
    parser = argparse.ArgumentParser(description="Convert the public Panda log to CSV.")
    parser.add_argument("clone", type=pathlib.Path, help="folder of the cloned repository")
    parser.add_argument("csv", type=pathlib.Path, help="file to write (.csv or .csv.gz)")
    arguments = parser.parse_args()
    if not arguments.clone.is_dir():
        sys.exit(f"{arguments.clone}: no such folder\n  help: clone the repository first (see --help of this file)")
    lines = [",".join(row) + "\n" for row in rows(arguments.clone / FOLDER)]
    opener = gzip.open if arguments.csv.suffix == ".gz" else open
    with opener(arguments.csv, "wt", encoding="utf-8", newline="\n") as file:
        file.writelines(lines)
    print(f"{arguments.csv}: {len(lines) - 1} samples of {JOINTS} joints", file=sys.stderr)


if __name__ == "__main__":
    main()
