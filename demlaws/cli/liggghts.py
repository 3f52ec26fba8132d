"""`demlaws liggghts build | check | export | run`."""

import argparse

from demlaws.cli import option
from demlaws.cli.refused import Refused
from demlaws.errors import DemlawsError

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
    export.add_argument("folder", help="folder to write")
    export.add_argument("--law", default="pohrt-popov", help="name of the law (default %(default)s)")
    export.add_argument(
        "--unloading",
        default="hertz",
        help="elastic, hertz, thornton, or a table file whose curve all contacts unload along (default %(default)s)",
    )
    export.add_argument("--unloading-law", help="name of a law whose curve each contact unloads along, in place of --unloading")
    options = {"type": option, "action": "append", "default": [], "metavar": "NAME=VALUE"}
    export.add_argument("--unloading-option", **options, help="an option of that law")
    export.add_argument("--option", **options, help="an option of the law")
    export.add_argument("--radius", type=float, nargs="+", required=True, help="grain radius [m], one a particle type")
    for name, default, text in (
        ("sq", [0.0], "rms roughness Sq of a grain's own surface [m]; two grains have σ² = Sq1² + Sq2²"),
        ("fractal-dimension", [None], "fractal dimension of the surface, 2 to 3"),
        ("young", [60.6e9], "Young's modulus [Pa]"),
        ("poisson", [0.25], "Poisson's ratio"),
        ("hardness", [None], "indentation hardness [Pa]"),
        ("density", [2650.0], "density [kg/m³]"),
    ):
        shown = "" if default == [None] else f" (default {default[0]:g})"
        export.add_argument(f"--{name}", type=float, nargs="+", default=default, help=f"{text}: one, or one a type{shown}")
    export.add_argument("--roughness", action=Refused, remedy="give --sq, the rms roughness of each grain's own surface")
    export.add_argument("--rtol", type=float, default=1e-5, help="relative tolerance of the tables (default %(default)g)")
    export.add_argument("--count", type=int, default=1000, help="number of grains (default %(default)s)")
    export.add_argument("--stock", choices=("hertz", "edinburgh"), help="fit this stock model instead; needs no compiler")
    export.add_argument("--load", type=float, help="contact force [N] of the fit, and the largest expected (default 10)")
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


def _each(arguments, name, count):
    values = getattr(arguments, name)
    if len(values) not in (1, count):
        raise DemlawsError(f"--{name.replace('_', '-')} has {len(values)} values for {count} radii: give one, or one a radius")
    return values if len(values) == count else values * count


def _export(arguments):
    from demlaws.contact import Material, Surface
    from demlaws.liggghts.export import Grain, export
    from demlaws.make import law

    count = len(arguments.radius)
    columns = [_each(arguments, name, count) for name in ("sq", "fractal_dimension", "young", "poisson", "hardness", "density")]
    grains = [
        Grain(radius, Material(young, poisson, hardness, density), Surface(sq, dimension, hardness))
        for radius, sq, dimension, young, poisson, hardness, density in zip(arguments.radius, *columns, strict=True)
    ]
    options, unloading = dict(arguments.option), arguments.unloading
    if arguments.unloading_law is not None:
        contact = grains[0].contact(grains[0])
        unloading = law(arguments.unloading_law, contact, **dict(arguments.unloading_option))
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
