"""What `demlaws liggghts` and `demlaws lammps` share: build | check | export | run."""

import argparse
import importlib

from demlaws.cli import example
from demlaws.cli.grains import grain_arguments, grains_of

EXPORT_EXAMPLE = """\
  demlaws {name} export case --law pohrt-popov --radius 0.004 0.005 --sq 1.7e-6 --fractal-dimension 2.22
  cd case && ./run.sh 2"""
RUN_EXAMPLE = """\
  demlaws {name} run in.case -np 2 -var steps 5000
  demlaws {name} run in.case -echo screen -var radii 0.004 0.005 0.006    (what it does not know goes to {engine})"""


def register_engine(subparsers, name, engine, *, builds, forces, more="", words=lambda arguments: {}):
    """Add the sub-command of an engine with its own sub-commands; returns the parser of `export`.

    builds, forces: what its build is said to do; more: further examples of export; words: further arguments of its export.
    """
    parser = subparsers.add_parser(name, **example(f"  demlaws {name} check"))
    parts = parser.add_subparsers(dest="part", required=True, metavar="PART")

    def part(name_of_part):
        module = importlib.import_module(f"demlaws.{name}.{name_of_part}")
        return getattr(module, name_of_part)

    def build(arguments):
        print(part("build")(portable=arguments.portable, force=arguments.force))

    def check(arguments):
        part("check")()

    def export(arguments):
        grains, unloading, options = grains_of(arguments)
        given = {"rtol": arguments.rtol, "load": arguments.load, "count": arguments.count, **words(arguments)}
        path = part("export")(arguments.folder, arguments.law, grains, unloading, options, **given)
        if given.get("stock"):
            print((path.parent / "fit.txt").read_text(), end="")
        print(f"wrote {path}; start {path.parent / 'run.sh'}")

    def run(arguments):
        # options may stand behind the input, too; what is none of ours is the engine's
        ours = argparse.ArgumentParser(prog=f"demlaws {name} run", add_help=False, allow_abbrev=False)
        _run_options(ours, default=argparse.SUPPRESS)
        arguments, rest = ours.parse_known_args(arguments.rest, arguments)
        part("run")(
            arguments.input,
            arguments.np,
            plugin=not arguments.stock,
            echo=True,
            portable=arguments.portable,
            arguments=rest[1:] if rest[:1] == ["--"] else rest,
        )

    one = parts.add_parser("build", help=builds, **example(f"  demlaws {name} build"))
    one.add_argument("--portable", action="store_true", help="no -march=native: for a cluster of unlike nodes")
    one.add_argument("--force", action="store_true", help=forces)
    one.set_defaults(func=build)

    one = parts.add_parser("check", help="prove the plugin on this machine (15 s)", **example(f"  demlaws {name} check"))
    one.set_defaults(func=check)

    text = example(EXPORT_EXAMPLE.format(name=name) + more)
    writes = parts.add_parser("export", help="write a ready case: tables, input, runscript", **text)
    grain_arguments(writes)
    writes.set_defaults(func=export)

    one = parts.add_parser("run", help="run an input with the plugin", **example(RUN_EXAMPLE.format(name=name, engine=engine)))
    _run_options(one)
    one.add_argument("input", help=f"input script; {engine} runs in its folder")
    one.add_argument("rest", nargs=argparse.REMAINDER, metavar="...", help=f"the options above, and any of {engine}'s own")
    one.set_defaults(func=run)
    return writes


def _run_options(parser, **default):
    parser.add_argument("-np", type=int, **default or {"default": 1}, help="number of MPI ranks (default 1)")
    parser.add_argument("--portable", action="store_true", **default, help="the plugin that `build --portable` makes")
    parser.add_argument("--stock", action="store_true", **default, help="without the plugin")
