"""`demlaws liggghts build | check | export | run`."""

import argparse

from demlaws.cli.arguments import force
from demlaws.cli.grains import grain_arguments, grains_of

EXPORT_EXAMPLE = """example:
  demlaws liggghts export case --law pohrt-popov --radius 0.004 0.005 --sq 1.7e-6 --fractal-dimension 2.22
  cd case && ./run.sh 2
without a compiler:
  demlaws liggghts export case --stock hertz --load 10 --radius 0.004 --sq 1.7e-6 --fractal-dimension 2.22"""
RUN_EXAMPLE = """examples:
  demlaws liggghts run in.case -np 2 -var steps 5000
  demlaws liggghts run in.case -echo screen -var radii 0.004 0.005 0.006    (what it does not know goes to LIGGGHTS)"""


def register(subparsers):
    """Add the sub-command and its own sub-commands."""
    raw = {"formatter_class": argparse.RawDescriptionHelpFormatter}
    parser = subparsers.add_parser(
        "liggghts",
        epilog="example:\n  demlaws liggghts check",
        **raw,
    )
    parts = parser.add_subparsers(dest="part", required=True, metavar="PART")

    build = parts.add_parser(
        "build", help="compile the plugin, print its path", epilog="example:\n  demlaws liggghts build", **raw
    )
    build.add_argument("--portable", action="store_true", help="no -march=native: for a cluster of unlike nodes")
    build.add_argument("--force", action="store_true", help="compile even if the cache has it")
    build.set_defaults(func=_build)

    check = parts.add_parser(
        "check", help="prove the plugin on this machine (15 s)", epilog="example:\n  demlaws liggghts check", **raw
    )
    check.set_defaults(func=_check)

    export = parts.add_parser("export", help="write a ready case: tables, input, runscript", epilog=EXPORT_EXAMPLE, **raw)
    grain_arguments(export)
    export.add_argument("--stock", choices=("hertz", "edinburgh"), help="fit this stock model instead; needs no compiler")
    export.add_argument("--load", type=force, help="contact force [N] of the fit, and the largest expected (default 10)")
    export.set_defaults(func=_export)

    run = parts.add_parser("run", help="run an input with the plugin", epilog=RUN_EXAMPLE, **raw)
    _run_options(run)
    run.add_argument("input", help="input script; LIGGGHTS runs in its folder")
    run.add_argument("rest", nargs=argparse.REMAINDER, metavar="...", help="the options above, and any of LIGGGHTS's own")
    run.set_defaults(func=_run)


def _run_options(parser, **default):
    parser.add_argument("-np", type=int, **default or {"default": 1}, help="number of MPI ranks (default 1)")
    parser.add_argument("--portable", action="store_true", **default, help="the plugin that `build --portable` makes")
    parser.add_argument("--stock", action="store_true", **default, help="without the plugin")


def _build(arguments):
    from demlaws.liggghts.build import build

    print(build(portable=arguments.portable, force=arguments.force))


def _check(arguments):
    from demlaws.liggghts.check import check

    check()


def _export(arguments):
    from demlaws.liggghts.export import export

    grains, unloading, options = grains_of(arguments)
    path = export(
        arguments.folder,
        arguments.law,
        grains,
        unloading,
        options,
        rtol=arguments.rtol,
        stock=arguments.stock,
        load=arguments.load,
        count=arguments.count,
    )
    if arguments.stock:
        print((path.parent / "fit.txt").read_text(), end="")
    print(f"wrote {path}; start {path.parent / 'run.sh'}")


def _run(arguments):
    from demlaws.liggghts.run import run

    # options may stand behind the input, too; what is none of ours is LIGGGHTS's
    ours = argparse.ArgumentParser(prog="demlaws liggghts run", add_help=False, allow_abbrev=False)
    _run_options(ours, default=argparse.SUPPRESS)
    arguments, rest = ours.parse_known_args(arguments.rest, arguments)
    run(
        arguments.input,
        arguments.np,
        plugin=not arguments.stock,
        echo=True,
        portable=arguments.portable,
        arguments=rest[1:] if rest[:1] == ["--"] else rest,
    )
