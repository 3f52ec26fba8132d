"""The command `demlaws check`: every engine that is found, and what a fault report needs."""

import importlib.metadata
import platform
import subprocess
import sys

from demlaws.errors import DemlawsError, page

ENGINES = {"yade": ("check", "--quick"), "liggghts": ("check",), "lammps": ("check",)}
PACKAGES = ("numpy", "numba", "scipy", "matplotlib")


def register(add):
    """Add `check`."""
    parser = add(
        description="Run the check of each engine that is found (YADE: two laws): forces in the engine against the law. "
        "Exit status: 0 if all passed, 1 otherwise. The first time on a machine the plugins and laws are compiled (a minute).",
        epilog="example: demlaws check --report > report.txt",
    )
    line = f"print versions and all lines of the checks, for a report ({page('install')})"
    parser.add_argument("--report", action="store_true", help=line)


def versions():
    """{name: version} of what the laws depend on."""
    import demlaws

    found = {"demlaws": demlaws.__version__, "Python": platform.python_version(), "system": platform.platform()}
    for name in PACKAGES:
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            found[name] = "not installed"
    return found


def executable(engine):
    """Path of an engine's program; DemlawsError if it is not installed."""
    from demlaws.lammps.run import executable as lammps
    from demlaws.liggghts.run import executable as liggghts
    from demlaws.yade.run import executable as yade

    return {"yade": yade, "liggghts": liggghts, "lammps": lammps}[engine]()


def checked(engine):
    """(verdict, output) of an engine's own check."""
    try:
        executable(engine)
    except DemlawsError as error:
        return "not found", str(error)
    line = [sys.executable, "-m", "demlaws", engine, *ENGINES[engine]]
    done = subprocess.run(line, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace")
    return "all good" if done.returncode == 0 else "failed", done.stdout.strip()


def run(arguments, result):
    """Do what the command's arguments ask."""
    found, results = versions(), {}
    if arguments.report:
        result.print(*(f"{name:12}{version}" for name, version in found.items()))
    else:
        result.print(f"demlaws {found['demlaws']}, Python {found['Python']}, numpy {found['numpy']}, numba {found['numba']}")
    for engine in ENGINES:
        verdict, output = checked(engine)
        results[engine] = {"verdict": verdict, "output": output}
        result.print(f"{engine:12}{verdict}")
        if arguments.report or verdict != "all good":
            result.print(*(f"    {line}" for line in output.splitlines()))
    result.values = {"versions": found, "engines": results}
    return 1 if any(one["verdict"] == "failed" for one in results.values()) else 0
