"""The command `demlaws yade`."""

import argparse

from demlaws.errors import DemlawsError


def register(subparsers):
    """Add `yade` with its sub-commands `check` and `run`."""
    parser = subparsers.add_parser(
        "yade",
        description="The laws inside Debian's YADE.",
        epilog="example: demlaws yade run yade_scripts/two_spheres.py --quick",
    )
    commands = parser.add_subparsers(dest="yade_command", required=True, metavar="COMMAND")
    check = commands.add_parser(
        "check",
        help="versions, what the native bridge finds, self-test of every law",
        description="Start YADE, verify what the native bridge assumes, and test every law and unloading rule on two spheres.",
        epilog="example: demlaws yade check",
    )
    check.set_defaults(func=_check)
    run = commands.add_parser(
        "run",
        help="run a script under YADE with this package importable",
        description="Run a script under Debian's YADE, with this package importable and without the graphical interface.",
        epilog="example: demlaws yade run yade_scripts/impact.py --quick",
    )
    run.add_argument("--threads", type=int, default=1, metavar="N", help="OpenMP threads (default 1)")
    run.add_argument("--gui", action="store_true", help="with the graphical interface")
    run.add_argument("--batch", metavar="TABLE", help="run once for each line of this parameter table (yade-batch)")
    run.add_argument("script")
    run.add_argument("arguments", nargs=argparse.REMAINDER, help="arguments of the script")
    run.set_defaults(func=_run)


def _check(arguments):
    from demlaws.yade.run import run

    return run(_file("check.py")).returncode


def _run(arguments):
    from demlaws.yade.run import run

    if arguments.threads < 1:
        raise DemlawsError(f"--threads {arguments.threads}: at least 1")
    return run(arguments.script, arguments.arguments, arguments.threads, arguments.gui, arguments.batch).returncode


def _file(name):
    from pathlib import Path

    return Path(__file__).parent.parent / "yade" / name
