"""`demlaws lammps build | check | export | run`."""

import argparse

from demlaws.cli import example
from demlaws.cli.arguments import force
from demlaws.cli.grains import grain_arguments, grains_of

EXPORT_EXAMPLE = """\
  demlaws lammps export case --law pohrt-popov --radius 0.004 0.005 --sq 1.7e-6 --fractal-dimension 2.22
  cd case && ./run.sh 2"""
RUN_EXAMPLE = """\
  demlaws lammps run in.case -np 2 -var steps 5000
  demlaws lammps run in.case -echo screen -var radii 0.004 0.005 0.006    (what it does not know goes to LAMMPS)"""


def register(subparsers):
    """Add the sub-command and its own sub-commands."""
    parser = subparsers.add_parser("lammps", **example("  demlaws lammps check"))
    parts = parser.add_subparsers(dest="part", required=True, metavar="PART")

    build = parts.add_parser("build", help="path of the plugin; compiles it if need be", **example("  demlaws lammps build"))
    build.add_argument("--portable", action="store_true", help="no -march=native: for a cluster of unlike nodes")
    build.add_argument("--force", action="store_true", help="compile even if the wheel or the cache has it")
    build.set_defaults(func=_build)

    check = parts.add_parser("check", help="prove the plugin on this machine (15 s)", **example("  demlaws lammps check"))
    check.set_defaults(func=_check)

    export = parts.add_parser("export", help="write a ready case: tables, input, runscript", **example(EXPORT_EXAMPLE))
    grain_arguments(export)
    export.add_argument("--load", type=force, default=10.0, help="largest expected contact force [N] (default %(default)g)")
    export.set_defaults(func=_export)

    run = parts.add_parser("run", help="run an input with the plugin", **example(RUN_EXAMPLE))
    _run_options(run)
    run.add_argument("input", help="input script; LAMMPS runs in its folder")
    run.add_argument("rest", nargs=argparse.REMAINDER, metavar="...", help="the options above, and any of LAMMPS's own")
    run.set_defaults(func=_run)


def _run_options(parser, **default):
    parser.add_argument("-np", type=int, **default or {"default": 1}, help="number of MPI ranks (default 1)")
    parser.add_argument("--portable", action="store_true", **default, help="the plugin that `build --portable` makes")
    parser.add_argument("--stock", action="store_true", **default, help="without the plugin")


def _build(arguments):
    from demlaws.lammps.build import build

    print(build(portable=arguments.portable, force=arguments.force))


def _check(arguments):
    from demlaws.lammps.check import check

    check()


def _export(arguments):
    from demlaws.lammps.export import export

    grains, unloading, options = grains_of(arguments)
    path = export(
        arguments.folder,
        arguments.law,
        grains,
        unloading,
        options,
        rtol=arguments.rtol,
        load=arguments.load,
        count=arguments.count,
    )
    print(f"wrote {path}; start {path.parent / 'run.sh'}")


def _run(arguments):
    from demlaws.lammps.run import run

    # options may stand behind the input, too; what is none of ours is LAMMPS's
    ours = argparse.ArgumentParser(prog="demlaws lammps run", add_help=False, allow_abbrev=False)
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
