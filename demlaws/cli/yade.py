"""The command `demlaws yade`."""

import subprocess
import sys
from pathlib import Path

from demlaws.cli import Parser
from demlaws.errors import DemlawsError

OURS = ("-j", "--threads", "--batch", "--law-file")
WITH_VALUE = (*OURS, "--cores", "--nice", "-f", "-L", "--libs", "--job-threads", "--lines", "--log")
"""Options, ours and of yade and yade-batch, whose value may be the next word."""


class _PassesOn(Parser):
    """A parser that takes options before the first other word, and keeps those that it does not know for YADE."""

    passes_on = False

    def parse_known_args(self, args=None, namespace=None):
        if not self.passes_on:
            return super().parse_known_args(args, namespace)
        end = 0
        while end < len(args) and args[end].startswith("-"):
            end += 2 if args[end] in WITH_VALUE else 1
        namespace, unknown = super().parse_known_args(args[:end], namespace)
        namespace.yade_options, namespace.script, namespace.arguments = (
            unknown,
            (args[end : end + 1] or [None])[0],
            args[end + 1 :],
        )
        return namespace, []


def register(add):
    """Add `yade` with its sub-commands `check` and `run`."""
    parser = add(
        description="Uses the laws in Debian's YADE.",
        epilog="example: demlaws yade run -x yade_scripts/two_spheres.py --quick",
    )
    commands = parser.add_subparsers(dest="yade_command", required=True, metavar="COMMAND", parser_class=_PassesOn)
    check = commands.add_parser(
        "check",
        help="print versions, test the laws inside YADE",
        description="Start YADE, verify what demlaws assumes of it, and test every law with its default rule and "
        "every other rule with one law, on two spheres. The first time on a machine each takes some seconds to compile.",
        epilog="example: demlaws yade check --quick",
    )
    extent = check.add_mutually_exclusive_group()
    extent.add_argument("--quick", action="append_const", dest="extent", const="--quick", help="two laws only")
    extent.add_argument("--all", action="append_const", dest="extent", const="--all", help="every law with every rule")
    check.set_defaults(func=_check)
    run = commands.add_parser(
        "run",
        help="run a script under YADE with this package importable",
        shows_json=False,
        description="Run a script under YADE with this package importable. As with `yade`, the interpreter stays open when the "
        "script has ended, unless -x is given. Options before the script that are not listed here go to YADE (yade-batch) as "
        "they are, for instance --cores=0,1. Without --gui the graphical interface is not started. Where demlaws is "
        "installed in YADE's Python, `yade SCRIPT` is equivalent.",
        epilog="example: demlaws yade run -x yade_scripts/impact.py --quick",
    )
    run.add_argument("-x", dest="leave", action="store_true", help="exit when the script has ended (status 1 if it failed)")
    run.add_argument("-j", "--threads", type=int, default=1, help="OpenMP threads (default 1)")
    run.add_argument("--gui", action="store_true", help="start the graphical interface")
    run.add_argument("--batch", metavar="TABLE", help="run once for each line of this parameter table (yade-batch)")
    run.usage = "demlaws yade run [-x] [-j COUNT] [--gui] [--batch TABLE] [options of YADE] SCRIPT [arguments of the script]"
    run.passes_on = True
    run.set_defaults(func=_run)


def _check(arguments, result):
    from demlaws.yade.run import command, environment, remedy

    words = [*(arguments.extent or []), *(f"--law-file={file}" for file in getattr(arguments, "law_files", []))]
    line, begun = command(Path(__file__).parent.parent / "yade" / "check.py", words), False
    if Path(line[0]).name != "yade":
        print(f"program: {line[0]}", file=sys.stderr)
    with subprocess.Popen(line, env=environment(), stdout=subprocess.PIPE, text=True, errors="replace") as process:
        for text in process.stdout:
            begun = begun or text.startswith("demlaws ")
            result.print(text.rstrip())
    if not begun:
        raise DemlawsError(f"{line[0]} ended with status {process.returncode} before the check began: is it YADE? {remedy()}")
    return process.returncode


def _run(arguments, _):
    from demlaws.yade.run import command, exec_yade, run_batch

    if arguments.script is None:
        raise DemlawsError("no script was given: demlaws yade run [options] SCRIPT [its arguments]")
    if files := getattr(arguments, "law_files", []):
        raise DemlawsError(f"--law-file {files[0]}: YADE is another process; write dl.load_laws({files[0]!r}) in the script")
    if arguments.threads < 1:
        raise DemlawsError(f"--threads {arguments.threads}: at least 1")
    if arguments.json:
        raise DemlawsError("--json is not available for yade run: the script prints to the standard output itself")
    options = {"gui": arguments.gui, "batch": arguments.batch, "stay": not arguments.leave, "options": arguments.yade_options}
    line = command(arguments.script, arguments.arguments, arguments.threads, **options)
    return exec_yade(line) if arguments.batch is None else run_batch(line)
