"""`demlaws choose`: the cheapest law within a scene's tolerance."""

from pathlib import Path

from demlaws.cli import example
from demlaws.cli.output import csv_file, progress, table_file
from demlaws.errors import DemlawsError

FIELDS = ("error", "ns", "step_factor", "step", "state_bytes", "table_rows", "meets")
TITLES = ("choice", *(f"{name}_s" if name == "step" else name for name in FIELDS))


def register(add):
    """Add this command."""
    parser = add(
        description="Ranks the combinations of law, unloading rule and evaluation (formula or table) that meet the tolerance "
        "of a scene by their stored cost, and reports the neglected effects with their errors. For a packing under pressure "
        "it also recommends a stiffness reduction and a loading rate.",
        **example(
            "  demlaws choose --template > ballast.toml      (every key of a scene, with its meaning)\n"
            "  demlaws choose ballast.toml --out ballast.tbl\n"
            "  demlaws choose ballast.toml --soften --out ballast.tbl"
        ),
    )
    parser.add_argument("scene", type=Path, nargs="?", help="scene file (TOML; -: standard input)")
    parser.add_argument("--template", action="store_true", help="only print a scene file with every key and its meaning")
    parser.add_argument("--soften", action="store_true", help="choose and write the law for softer grains, as recommended")
    parser.add_argument("--all", action="store_true", help="also list laws that miss the tolerance")
    parser.add_argument(
        "--out",
        type=Path,
        help="table file to write, one per pair of particle types; for LIGGGHTS and LAMMPS the folder of a complete case",
    )
    parser.add_argument("--csv", type=csv_file(TITLES), help="CSV file of all candidates")


def run(arguments, result):
    """Do what the command's arguments ask."""
    from demlaws.advice.choose import choose, table_name
    from demlaws.advice.scene import TEMPLATE, Scene

    if arguments.template:
        result.print(TEMPLATE.read_text(encoding="utf-8").rstrip("\n"))
        return
    if arguments.scene is None:
        raise DemlawsError("give a scene file, or --template for one to fill in")
    scene = Scene.load(arguments.scene)
    if arguments.out is not None and not arguments.overwrite and scene.engine in ("python", "yade"):
        for kinds in scene.kinds():
            table_file.check(table_name(arguments.out, scene, kinds))
    advice = _advice(scene, arguments.soften)
    if arguments.soften:
        scene = advice.scene
    choices = choose(scene, progress=progress("choose"))
    name = scene.name or arguments.scene.stem
    _print_choices(result, choices, scene, name, arguments.all)
    result.values = {
        "scene": name,
        "quantity": scene.quantity,
        "tolerance": scene.tolerance,
        "reference": {"law": choices.reference.name, "unloading": choices.reference.unloading},
        "choices": [{"choice": c.describe(), **{name: getattr(c, name) for name in FIELDS}} for c in choices],
        "ruled_out": dict(choices.ruled_out),
        "notes": list(choices.notes),
    }
    result.write_csv(arguments.csv, TITLES, ((c.describe(), *(getattr(c, name) for name in FIELDS)) for c in choices))
    best = choices.best
    if not best.meets:
        raise DemlawsError(
            f"nothing meets the tolerance {scene.tolerance:g}: the best is {best.describe()} with {best.error:.2g}; "
            "use that tolerance, or give the reference's quantities (fractal dimension, hardness, yield pressure)"
        )
    _print_best(result, best, scene)
    if advice is not None:
        result.print(f"softer grains, {'applied here' if arguments.soften else 'with --soften'}:")
        result.print_wrapped("\n".join(advice.lines()))
    if scene.engine in ("python", "yade"):
        result.print(best.script(arguments.out or Path("law.tbl")))
    if arguments.out is not None:
        _write(result, best, scene, arguments.out)


def _print_choices(result, choices, scene, name, every):
    """The ranking, without the laws that miss the tolerance unless `every`, and what was ruled out."""
    from demlaws.advice.choose import by_reason
    from demlaws.advice.errors import QUANTITIES

    result.print_wrapped(f"{name}: {scene.quantity} within {scene.tolerance:g} ({QUANTITIES[scene.quantity]})")
    low, high = scene.force_range(scene.contacts(scene.effective_radii()[1])[0])
    result.print(
        f"loads {float(low):.3g} to {float(high):.3g} N on the largest contact, {'cyclic' if scene.unloads else 'monotonic'}"
    )
    result.print(f"reference: {choices.reference.name}, {choices.reference.unloading} unloading\n")
    result.print(f"{'error':>9} {'ns':>6} {'step':>6} {'state':>6} {'rows':>6}  law, unloading, evaluation")
    for choice in choices:
        if choice.meets or every:
            result.print_wrapped(
                f"{choice.error:9.2g} {choice.ns:6.2f} {choice.step_factor:6.3f} "
                f"{choice.state_bytes:4d} B {choice.table_rows:6d}  {choice.describe()}"
                f"{'' if choice.meets else ' (above the tolerance)'}",
                " " * 39,
            )
    result.print_wrapped(
        "(ns: stored time per contact of the law alone; step: stable step over that of the reference; order: by ns/step)"
    )
    for reason, plans in by_reason(choices.ruled_out).items():
        result.print_wrapped(f"ruled out: {'; '.join(plans)}: {reason}")
    for note in choices.notes:
        result.print_wrapped(f"note: {note}")


def _print_best(result, best, scene):
    from demlaws.timestep import STEP_SAFETY

    result.print(f"\nchosen: {best.describe()}")
    result.print(f"time step {best.step:.3g} s, at most {STEP_SAFETY:g} of the estimated stability limit")
    for physics, error in best.left_out:
        result.print(f"  neglected: {physics}: error of the {scene.quantity} {error:.2g}")


def _write(result, best, scene, out):
    """The case of an engine with plugins, else the tables of the chosen law."""
    from demlaws.advice.choose import table_name

    if scene.engine in ("liggghts", "lammps"):
        result.print(f"wrote {best.export(out)} and {len(list(out.glob('*.tbl')))} table(s)")
        return
    for kinds, table in best.tables().items():
        path = table_name(out, scene, kinds)
        table.save(path)
        result.print(f"wrote {path}")


def _advice(scene, mandatory):
    """Recommended stiffness reduction and rate, or None if none is known; an error if it is required."""
    from demlaws.advice import modulus
    from demlaws.advice.choose import reference_plan

    problem = None
    try:
        plan = reference_plan(scene)
        advice = modulus.recommend_modulus(scene, plan.name, dict(plan.options))
    except DemlawsError as error:
        advice, problem = None, error
    if mandatory and advice is None:
        raise problem or DemlawsError(
            f"tolerance = {scene.tolerance:g}: no known softening and rate meet it; give a larger one, or keep the modulus and "
            "load more slowly"
        )
    return advice
