#!/usr/bin/env python3
"""Times Pinocchio's C++ and this library on the same robot and states, and compares their torques.

    python3 benches/pinocchio/compare.py

Needs g++, cargo, Python 3.9 or newer with `venv`, and a network for the first run: it makes a virtual
environment in target/pinocchio, and installs the package `pin`, whose wheel carries Pinocchio's
headers, and Eigen. Only the standard library is used here.
"""

import argparse
import csv
import math
import random
import re
import subprocess
import sys
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
WORK = ROOT / "target" / "pinocchio"
PACKAGES = ["pin==4.1.0", "cmeel-eigen==3.4.1"]
# Without these Pinocchio's joint variant exceeds the limits of Boost's containers.
DEFINES = [
    "BOOST_FUSION_INVOKE_MAX_ARITY=12",
    "BOOST_MPL_CFG_NO_PREPROCESSED_HEADERS",
    "BOOST_MPL_LIMIT_LIST_SIZE=30",
    "BOOST_MPL_LIMIT_VECTOR_SIZE=30",
    "NDEBUG",
]
BUILDS = {"-O3": ["-O3"], "-O3 -march=native": ["-O3", "-march=native"]}
STATES = 1000


def run(command, **options):
    done = subprocess.run([str(c) for c in command], cwd=ROOT, text=True, **options)
    if done.returncode != 0:
        sys.exit(f"failed: {' '.join(str(c) for c in command)}\n{done.stdout or ''}{done.stderr or ''}")
    return done.stdout


# Lets Pinocchio read the URDF, and writes what bench.cpp takes.
READ_URDF = """
import sys, pinocchio
model = pinocchio.buildModelFromUrdf(sys.argv[1])
with open(sys.argv[2], "w") as file:
    for at, body in zip(list(model.jointPlacements)[1:], list(model.inertias)[1:]):
        parts = [at.rotation, at.translation, body.mass, body.lever, body.inertia]
        numbers = [x for p in parts for x in getattr(p, "ravel", lambda: [p])()]
        print(*(repr(float(x)) for x in numbers), file=file)
"""


def install(folder):
    """The Python of a virtual environment that has Pinocchio, and where its wheels put the headers."""
    python = folder / "bin" / "python"
    if not python.exists():
        print(f"making {folder}", file=sys.stderr)
        venv.create(folder, with_pip=True)
    run([python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", *PACKAGES])
    where = "import sysconfig; print(sysconfig.get_paths()['purelib'])"
    packages = run([python, "-c", where], stdout=subprocess.PIPE).strip()
    return python, Path(packages) / "cmeel.prefix" / "include"


def compile_cpp(include, flags, name):
    """The C++ program; Pinocchio's algorithms are templates, so nothing is linked."""
    folders = [f"-I{include}", f"-I{include / 'eigen3'}"]
    source = ROOT / "benches" / "pinocchio" / "bench.cpp"
    defines = [f"-D{d}" for d in DEFINES]
    run(["g++", "-std=c++17", "-w", *flags, *defines, *folders, source, "-o", WORK / name])
    return WORK / name


def panda_rows():
    """Rows of robots/panda.ron: Denavit-Hartenberg parameters, mass, centre of mass and tensor."""
    text = re.sub(r"//[^\n]*", "", (ROOT / "robots" / "panda.ron").read_text())
    number = r"(-?[\d.eE+-]+)"
    pattern = (
        rf"a: {number}, alpha: {number}, d: {number}, theta: 0\.0.*?"
        rf"mass: {number}, com: \({number}, {number}, {number}\),\s*"
        rf"tensor: \(xx: {number}, xy: {number}, xz: {number}, yy: {number}, yz: {number}, zz: {number}\)"
    )
    rows = [[float(x) for x in row] for row in re.findall(pattern, text, re.S)]
    if len(rows) != 7:
        sys.exit(f"robots/panda.ron: {len(rows)} rows with inertia understood instead of 7")
    return rows


def write_urdf(path):
    """The Panda as a URDF with the same link frames: modified DH is Rx(alpha) Tx(a) Tz(d) Rz(q)."""
    parts = ['<robot name="panda">', '<link name="link0"/>']
    for i, (a, alpha, d, mass, x, y, z, xx, xy, xz, yy, yz, zz) in enumerate(panda_rows(), 1):
        at = (a, -math.sin(alpha) * d, math.cos(alpha) * d)
        parts += [
            f'<link name="link{i}"><inertial><origin xyz="{x!r} {y!r} {z!r}"/><mass value="{mass!r}"/>',
            f'<inertia ixx="{xx!r}" ixy="{xy!r}" ixz="{xz!r}" iyy="{yy!r}" iyz="{yz!r}" izz="{zz!r}"/>',
            f'</inertial></link><joint name="joint{i}" type="revolute">',
            f'<parent link="link{i - 1}"/><child link="link{i}"/><axis xyz="0 0 1"/>',
            f'<origin xyz="{at[0]!r} {at[1]!r} {at[2]!r}" rpy="{alpha!r} 0 0"/>',
            '<limit lower="-3" upper="3" velocity="3" effort="100"/></joint>',
        ]
    path.write_text("\n".join([*parts, "</robot>\n"]))


def write_states(path):
    draw = random.Random(1)
    with path.open("w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow([f"{name}{j}" for name in ("q", "dq", "ddq") for j in range(1, 8)])
        for _ in range(STATES):
            table.writerow([repr(draw.uniform(-r, r)) for r in (3.0, 2.0, 10.0) for _ in range(7)])


def read_numbers(text):
    return [[float(x) for x in row] for row in csv.reader(text.splitlines())]


def ours():
    """ns per sample of our kernels, read off the table that `cargo bench` prints for 1000 samples."""
    text = run(["cargo", "bench", "--quiet", "--bench", "kernels"], stdout=subprocess.PIPE)
    unit = {"ns": 1e-3, "µs": 1.0, "ms": 1e3}
    lines = re.findall(r"─ (.+?)\s+\[.*?\]\s+([\d.]+) (ns|µs|ms)", text)
    return {name: float(value) * unit[u] for name, value, u in lines}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--venv", type=Path, default=WORK / "venv", help="virtual environment to use")
    folder = parser.parse_args().venv.resolve()
    WORK.mkdir(parents=True, exist_ok=True)
    urdf, robot = WORK / "panda.urdf", WORK / "panda.txt"
    states, torques = WORK / "states.csv", WORK / "torques.csv"
    write_urdf(urdf)
    write_states(states)

    python, include = install(folder)
    run([python, "-c", READ_URDF, urdf, robot])
    theirs = {}
    for i, (label, flags) in enumerate(BUILDS.items()):
        print(f"compiling against Pinocchio with g++ {label}", file=sys.stderr)
        binary = compile_cpp(include, flags, f"bench{i}")
        lines = run([binary, robot, states, torques], stdout=subprocess.PIPE).split()
        theirs[label] = dict(zip(lines[::2], map(float, lines[1::2])))
    run(["cargo", "build", "--quiet", "--release", "--bin", "lacuna"])
    mine = ours()

    print(f"\n{'ns per sample, one core':<26}{'lacuna':>8}", end="")
    print("".join(f"{'Pinocchio ' + label:>32}" for label in BUILDS))
    rows = [
        ("rnea, one by one", "rnea"),
        ("rnea, batched", "rnea"),
        ("regressor, one by one", "regressor"),
        ("regressor, batched", "regressor"),
        ("mass matrix, one by one", "mass_matrix"),
        ("mass matrix, batched", "mass_matrix"),
    ]
    for name, other in rows:
        cells = (f"{t[other]:>20.0f} ({t[other] / mine[name]:4.1f} times)" for t in theirs.values())
        print(f"{name:<26}{mine[name]:>8.0f}" + "".join(cells))

    command = ["cargo", "run", "--quiet", "--release", "--", "dynamics", "--robot", urdf, "--states", states]
    own = read_numbers(run(command, stdout=subprocess.PIPE).split("\n", 1)[1])
    reference = read_numbers(torques.read_text())
    if len(own) != len(reference):
        sys.exit(f"{len(own)} torque rows of ours, {len(reference)} of Pinocchio")
    worst = max(abs(a - b) for x, y in zip(own, reference) for a, b in zip(x, y))
    largest = max(abs(b) for y in reference for b in y)
    print(f"\n{STATES} states: torques differ by at most {worst:.1e} N m, the largest being {largest:.0f} N m")
    if not worst <= 1e-11 * largest:
        sys.exit("the torques do not agree")


if __name__ == "__main__":
    main()
