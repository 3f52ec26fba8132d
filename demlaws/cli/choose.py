"""`demlaws choose`: the cheapest law that a scene allows."""

from pathlib import Path

from demlaws.cli import example
from demlaws.cli.arguments import output
from demlaws.errors import DemlawsError

SCENE = """
ballast.toml (SI units):
  name = "ballast under a train"
  quantity = "stiffness"        # force, stiffness, overlap, energy, restitution
  tolerance = 0.1
  engine = "yade"               # python, yade, liggghts, lammps
  cyclic = true
  radii = [0.01, 0.03]          # smallest and largest grain, or classes = [0.01, 0.02, 0.03]: the sizes there are
  force = [1, 500]              # or pressure = [1e4, 2e5], or speed = 0.5
  yield_pressure = 1.66e9       # leave out if the bulk stays elastic
  [material]
  young = 60.6e9
  poisson = 0.25
  hardness = 6.27e9
  density = 2680
  [surface]                     # of each grain
  roughness = 1.7e-6
  fractal_dimension = 2.22
  # [measured]                  # or take surface and law from a fit to measured points
  # points = "points.csv"
  # radius = 4.35e-3"""


def register(subparsers):
    """Add this file's commands to the command line."""
    parser = subparsers.add_parser(
        "choose",
        description="Ranks laws, unloading rules and evaluations for a scene by measured cost among those that meet its "
        "tolerance; says what is left out and what that costs in error.",
        **example("  demlaws choose ballast.toml --out ballast.tbl\n" + SCENE),
    )
    parser.add_argument("scene", type=Path, help="scene file (TOML)")
    parser.add_argument("--all", action="store_true", help="list also those that miss the tolerance")
    parser.add_argument(
        "--out",
        type=Path,
        help="table file to write, one a pair of kinds of grain; for LIGGGHTS and LAMMPS the folder of a whole case",
    )
    parser.add_argument("--csv", type=output, help="file to write all candidates to")
    parser.add_argument("--figure", type=output, help="picture to draw: error against cost")
    parser.set_defaults(func=run)


def run(arguments):
    """Do what the command's arguments ask."""
    from tqdm import tqdm

    from demlaws import granite, plots
    from demlaws.advice.choose import choose, table_name
    from demlaws.advice.scene import Scene
    from demlaws.measure.errors import QUANTITIES
    from demlaws.plots import choose as plots_choose

    scene = Scene.load(arguments.scene)
    choices = choose(scene, progress=lambda plans: tqdm(plans, desc="choose", unit="law", leave=False, disable=None))
    print(f"{scene.name or arguments.scene.stem}: {scene.quantity} within {scene.tolerance:g} ({QUANTITIES[scene.quantity]})")
    low, high = scene.force_range(scene.contacts(scene.effective_radii()[1])[0])
    print(f"loads {float(low):.3g} to {float(high):.3g} N on the largest contact, {'cyclic' if scene.unloads else 'monotonic'}")
    reference = choices.reference
    print(f"reference: {reference.name}, {reference.unloading} unloading\n")
    engine = "" if choices.measured_in == "the law alone" else f"{'engine':>7} "
    print(f"{'error':>9} {'mean':>9} {'ns':>6} {engine}{'step':>6} {'state':>6} {'rows':>6}  law, unloading, evaluation")
    for choice in choices:
        if choice.meets or arguments.all:
            print(
                f"{choice.error:9.2g} {choice.mean_error:9.2g} {choice.ns:6.2f} "
                f"{f'{choice.engine_ns:7.1f} ' if engine else ''}{choice.step_factor:6.3f} "
                f"{choice.state_bytes:4d} B {choice.table_rows:6d}  {choice.describe()}{'' if choice.meets else '  MISSES'}"
            )
    print(f"(ns: of the law alone; copying overlap to force and stiffness: {choices.floor:.2f})")
    if engine:
        print(f"(engine: ns a contact of {choices.measured_in}, all of it; ranked by this over the step)")
    for what, why in choices.ruled_out.items():
        print(f"ruled out: {what}: {why}")
    for note in choices.notes:
        print(f"note: {note}")
    if arguments.csv is not None:
        rows = [
            (
                c.describe(),
                c.error,
                c.mean_error,
                c.ns,
                c.engine_ns,
                c.step_factor,
                c.step,
                c.state_bytes,
                c.table_rows,
                c.meets,
            )
            for c in choices
        ]
        titles = (
            "choice",
            "error",
            "mean_error",
            "ns",
            "engine_ns",
            "step_factor",
            "step_s",
            "state_bytes",
            "table_rows",
            "meets",
        )
        print(granite.save_csv(arguments.csv, titles, rows))
    if arguments.figure is not None:
        print(plots.save(plots_choose.choices_figure(choices), arguments.figure))
    best = choices.best
    if not best.meets:
        raise DemlawsError(
            f"nothing meets the tolerance {scene.tolerance:g}: the best is {best.describe()} with {best.error:.2g}; "
            "ask for that, or give the reference's quantities (fractal dimension, hardness, yield pressure)"
        )
    print(f"\nchosen: {best.describe()}, stable step {best.step:.3g} s")
    for what, error in best.left_out:
        print(f"  left out: {what}: costs {error:.2g} in {scene.quantity}")
    table = arguments.out or Path("law.tbl")
    print(best.script(table))
    if arguments.out is None:
        return
    if scene.engine in ("liggghts", "lammps"):
        print(f"wrote {best.export(arguments.out)} and {len(list(arguments.out.glob('*.tbl')))} table(s)")
        return
    for kinds, made in best.tables().items():
        path = table_name(arguments.out, scene, kinds)
        made.save(path)
        print(f"wrote {path}")
