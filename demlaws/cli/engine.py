"""`demlaws liggghts` and `demlaws lammps`: build | source | check | export | convert | run."""

import os

from demlaws.cli import Parser, example
from demlaws.cli.arguments import density, force, length, plain, pressure, whole
from demlaws.cli.contact import add_unloading_arguments
from demlaws.cli.output import other_file
from demlaws.errors import DemlawsError
from demlaws.laws import USUAL

EXPORT_EXAMPLE = """\
  demlaws {name} export case --law pohrt-popov --radius 0.004 0.005 --roughness 1.7e-6 --fractal-dimension 2.22
  cd case && ./run.sh 2"""
WITHOUT_COMPILER = """
without a compiler:
  demlaws liggghts export case --stock hertz --max-force 10 --radius 0.004 --roughness 1.7e-6 --fractal-dimension 2.22"""
CONVERT_EXAMPLE = """\
  demlaws table --law hertz --effective-radius 4mm --modulus 32.32GPa --out hertz.tbl
  demlaws {name} convert in.case --table hertz.tbl
  demlaws {name} run in.case.demlaws"""
RUN_EXAMPLE = """\
  demlaws {name} run in.case -np 2 -var steps 5000
  demlaws {name} run in.case -log case.log -screen none
  demlaws {name} run in.case -echo screen -var radii 0.004 0.005 0.006    (unknown options go to {engine})"""
PROPERTIES = (
    ("roughness", length, [None], "rms roughness Sq of a grain's own surface [m], 0: smooth; two grains have σ² = Sq1² + Sq2²"),
    ("fractal-dimension", plain, [None], "fractal dimension of the surface, 2 to 3"),
    ("young", pressure, [60.6e9], "Young's modulus [Pa]"),
    ("poisson", plain, [0.25], "Poisson's ratio"),
    ("hardness", pressure, [None], "indentation hardness [Pa]"),
    ("density", density, [2680.0], "density [kg/m³]"),
)
"""Options of `export` with one value, or one per grain type: name, kind, default, help."""


class _PartParser(Parser):
    """Of `run`: options that are not ours are the engine's."""

    def parse_known_args(self, args=None, namespace=None):
        namespace, unknown = super().parse_known_args(args, namespace)
        if "rest" in namespace:
            namespace.rest, unknown = unknown, []
        return namespace, unknown


def register(add):
    """Add the command of the engine whose name `add` holds, with its sub-commands."""
    (name,) = add.args
    parser = add(**example(f"  demlaws {name} check"))
    parts = parser.add_subparsers(dest="part", required=True, metavar="COMMAND", parser_class=_PartParser)
    _add_build(parts, name)
    _add_source(parts, name)
    checks = parts.add_parser("check", help="test the plugin on this machine (15 s)", **example(f"  demlaws {name} check"))
    checks.set_defaults(func=lambda _, result: _function(name, "check")(result.print))
    _add_export(parts, name)
    _add_convert(parts, name)
    _add_run(parts, name)


def _function(engine, name):
    """A public function of `demlaws.liggghts` or `demlaws.lammps`."""
    from demlaws import lammps, liggghts

    return getattr({"liggghts": liggghts, "lammps": lammps}[engine], name)


def _add_build(parts, name):
    def build(arguments, result):
        result.print(_function(name, "build")(portable=arguments.portable, rebuild=arguments.rebuild))

    builds = parts.add_parser("build", help="compile the plugin, print its path", **example(f"  demlaws {name} build"))
    builds.add_argument("--portable", action="store_true", help="for any x86-64 processor, for clusters with different nodes")
    builds.add_argument("--rebuild", action="store_true", help="compile even if the plugin exists")
    builds.set_defaults(func=build)


def _add_source(parts, name):
    place, release = {"liggghts": ("src", "3.8.0"), "lammps": ("src/GRANULAR", "4 Feb 2025 or later")}[name]
    engine = name.upper()
    text = example(f"  demlaws {name} source ~/{name}/{place}")
    sources = parts.add_parser("source", help=f"write the models as sources of {engine}, to be compiled with it", **text)
    sources.add_argument("folder", help=f"folder {place} of {engine}'s sources, {release}")
    sources.set_defaults(func=lambda arguments, result: result.print(_function(name, "source")(arguments.folder)))


def _add_export(parts, name):
    def export(arguments, result):
        from demlaws.plugins.grains import Case

        values = {"rtol": arguments.rtol, "max_force": arguments.max_force, "count": arguments.count}
        values |= {name: getattr(arguments, name) for name in ("shear_ratio", "levels", "friction_pressure")}
        stock, options = getattr(arguments, "stock", None), dict(arguments.option)
        case = Case(arguments.law, _grains_of(arguments), arguments.unloading, options, stock=stock, **values)
        result.print(case.title)
        path = _function(name, "export")(arguments.folder, case)
        if stock:
            result.print((path.parent / "fit.txt").read_text().rstrip("\n"))
        result.print(f"wrote {path}; start {path.parent / 'run.sh'}")

    text = example(EXPORT_EXAMPLE.format(name=name) + (WITHOUT_COMPILER if name == "liggghts" else ""))
    exports = parts.add_parser("export", help="write a complete case: tables, input, run script", **text)
    _grain_arguments(exports)
    if name == "liggghts":
        exports.add_argument(
            "--stock",
            choices=("hertz",),
            help="write the engine's own hertz model with a fitted modulus (no plugin, no compiler)",
        )
    exports.set_defaults(func=export)


def _add_convert(parts, name):
    def convert(arguments, result):
        from demlaws.plugins.convert import convert_file

        out = arguments.out or other_file(arguments.input + ".demlaws")
        if not arguments.overwrite:
            other_file.check(out)
        table, pairs = _tables_of(arguments.table)
        out, conversion = convert_file(arguments.input, name, table, out=out, pairs=pairs)
        result.values = {"file": out, "notes": conversion.notes}
        last = "no line converted, no file written" if out is None else f"wrote {out}"
        result.print_wrapped("\n".join([*conversion.report(arguments.input), last]))
        return 0 if conversion.complete else 1

    converts = parts.add_parser(
        "convert",
        help="replace the contact model of an input by demlaws/table",
        description="Replaces the contact model in the pair_style, pair_coeff, wall and surface lines of an input by "
        "demlaws/table. Exit status: 0 if every granular line was converted and none stops the run; 1 if such lines remain, "
        "as in `if` and variables: they are named.",
        **example(CONVERT_EXAMPLE.format(name=name)),
    )
    converts.add_argument("input", help="input script with stock models")
    converts.add_argument(
        "--table",
        required=True,
        nargs="+",
        action="append",
        metavar=("[I J] FILE", ""),
        help="table file of the law (`demlaws table` writes one), or of particle types I and J only, once per pair of types",
    )
    converts.add_argument("--out", type=other_file, help="file to write (default: INPUT.demlaws)")
    converts.set_defaults(func=convert)


def _tables_of(given):
    """(table of all other types, {(I, J): table}) of the words behind each --table."""
    tables = {}
    for words in given:
        if len(words) not in (1, 3) or not all(word.isdigit() and int(word) for word in words[:-1]):
            raise DemlawsError(f"--table {' '.join(words)}: write --table FILE, or --table I J FILE with two particle types")
        types = tuple(sorted(map(int, words[:-1]))) or None
        if tables.setdefault(types, words[-1]) != words[-1]:
            raise DemlawsError(f"--table {' '.join(words)}: these types have another table, {tables[types]}: leave one")
    if None not in tables:
        raise DemlawsError("--table FILE is missing: the table of walls, and of all types without their own")
    return tables.pop(None), tables


_RANKS = ("OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "MPI_LOCALNRANKS")


def _add_run(parts, name):
    engine = name.upper()

    def run(arguments, _):
        if arguments.json:
            raise DemlawsError(f"--json is not available for {name} run: {engine} prints to the standard output itself")
        if ranks := next((os.environ[word] for word in _RANKS if os.environ.get(word, "1") != "1"), None):
            raise DemlawsError(  # each rank would start the whole run
                f"demlaws starts the ranks itself: write  demlaws {name} run INPUT -np {ranks}  without mpirun in front of it"
            )
        screen = [] if arguments.screen in (None, "none") else ["-screen", arguments.screen]
        _function(name, "run")(
            arguments.script,
            arguments.np,
            plugin=not arguments.stock,
            log=arguments.log,
            echo=arguments.screen != "none",  # LIGGGHTS 3.8.0 crashes at `fix mesh` with its own -screen none
            portable=arguments.portable,
            arguments=[*arguments.rest, *screen],
        )

    text = example(RUN_EXAMPLE.format(name=name, engine=engine))
    runs = parts.add_parser("run", help="run an input with the plugin", shows_json=False, **text)
    text = f"input script, first of all; {engine} runs in its folder; unknown options go to {engine}"
    runs.add_argument("script", metavar="INPUT", help=text)
    runs.add_argument("-np", type=int, default=1, help="number of MPI ranks (default 1)")
    runs.add_argument("--portable", action="store_true", help="use the plugin of `build --portable`")
    runs.add_argument("--stock", action="store_true", help="run without the plugin")
    runs.add_argument("-log", "-l", metavar="FILE", help="log file (default log.ENGINE)")
    runs.add_argument("-screen", "-sc", metavar="none|FILE", help="file for the printed output; none: no output")
    runs.set_defaults(func=run, rest=[])


def _grain_arguments(export):
    export.add_argument("folder", help="folder to write")
    export.add_argument("--law", default=USUAL, help="name of the law (default %(default)s)")
    add_unloading_arguments(export)
    export.add_argument(
        "--radius", type=length, nargs="+", required=True, help="grain radius in m, or with a unit (4mm): one per particle type"
    )
    for name, kind, default, text in PROPERTIES:
        suffix = "" if default == [None] else f" (default {default[0]:g})"
        export.add_argument(f"--{name}", type=kind, nargs="+", help=f"{text}: one, or one per type{suffix}")
    export.add_argument(
        "--material",
        nargs="+",
        help="material with typical values of the six quantities above (list: demlaws materials): one, or one per type; values "
        "that are given replace its own",
    )
    export.add_argument(
        "--max-force", type=force, default=10.0, help="largest expected contact force [N] (default %(default)g)"
    )
    export.add_argument("--rtol", type=plain, default=1e-5, help="relative tolerance of the tables (default %(default)s)")
    export.add_argument(
        "--shear-ratio", type=plain, help="K_t/K of all contacts, above 0, at most 4/3 (default: that of Poisson's ratio)"
    )
    export.add_argument("--levels", type=whole(), help="levels of the shear model, 1 to 8 (default 3)")
    text = "C1 and C2 [1/Pa]: friction above that of the case by C1/(1 + C2 p) at a mean pressure p of the contact"
    export.add_argument("--friction-pressure", type=plain, nargs=2, help=text)
    export.add_argument("--count", type=whole(), default=1000, help="number of grains (default %(default)s)")


def _grains_of(arguments):
    """The case's `Grain`s."""
    from demlaws.contact import Material, Surface
    from demlaws.materials import typical
    from demlaws.plugins.grains import Grain

    count, columns = len(arguments.radius), []
    materials = [typical(name) for name in arguments.material or ()]
    for name, _, default, _ in [("material", None, [None], None), *PROPERTIES]:
        key = name.replace("-", "_")
        values = getattr(arguments, key) or [material[key].value for material in materials] or default
        if len(values) not in (1, count):
            raise DemlawsError(f"--{name} has {len(values)} values for {count} radii: give one, or one per radius")
        columns.append(values if len(values) == count else values * count)
    return tuple(
        Grain(radius, Material(young, poisson, hardness, density), Surface(sq, dimension, hardness))
        for radius, sq, dimension, young, poisson, hardness, density in zip(arguments.radius, *columns[1:], strict=True)
    )
