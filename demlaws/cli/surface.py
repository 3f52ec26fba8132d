"""`demlaws surface`: height maps, their contact, their law."""

import math

from demlaws.cli import example
from demlaws.cli.arguments import force, length, plain, whole
from demlaws.cli.contact import add_contact_arguments, bodies_from, contact_from, draw
from demlaws.cli.output import other_file, picture_file, table_file
from demlaws.errors import DemlawsError
from demlaws.laws import ASPERITY


def register(add):
    """Add this command."""
    surface = add(
        usage="demlaws surface FILE [options]\n"
        "       demlaws surface contact FILE [options]\n"
        "       demlaws surface synthetic --out FILE [options]\n"
        "       demlaws surface summits FILE [--effective-radius R] [options]",
        description="The first form levels a height map and prints its roughness and fractal dimension; `contact` computes the "
        "contact with a smooth ball; `summits` counts nine-point summits; `synthetic` generates a self-affine map. FILE is "
        ".npy, .npz, .csv, .txt, .tsv or .asc, or a file of an instrument (read by SurfaceTopography).",
        **example(
            "  demlaws surface synthetic --size 512 --pixel 0.5um --hurst 0.8 --roughness 1.3um --seed 1 --out map.asc\n"
            "  demlaws surface map.asc --form 2 --figure map.png\n"
            "  demlaws surface contact map.asc --radius 3.175mm inf --young 430GPa 75.2GPa --poisson 0.17 0.34 \\\n"
            "      --hardness 0.24GPa --load 0.2 --table map.tbl --figure contact.png\n"
            "  demlaws surface summits map.asc --effective-radius 5mm --crop 0.2mm"
        ),
    )
    surface.add_argument("words", nargs="+", metavar="FILE", help="see above")
    surface.add_argument("--pixel", type=length, help="pixel size, if the file does not contain it: 0.8um")
    surface.add_argument("--unit", default="m", help="unit of the heights in a text or .npy file (default m)")
    surface.add_argument("--missing", type=plain, help="height that stands for missing pixels, in the file's unit (-9999)")
    surface.add_argument("--channel", help="name of the channel of an instrument's file (default: the first with heights)")
    surface.add_argument("--despike", action="store_true", help="treat spikes and fillers as missing pixels (5 x 5 median)")
    form = "order of the subtracted polynomial (default 2, or a sphere where that leaves less; -1: none)"
    surface.add_argument("--form", type=whole(-1, 8), default=2, help=form)
    surface.add_argument("--crop", type=length, metavar="WIDTH", help="use the square of this side in the middle of the map")
    surface.add_argument(
        "--wavelengths",
        type=length,
        nargs=2,
        metavar=("SHORTEST", "LONGEST"),
        help="wavelengths used to fit the fractal dimension",
    )
    surface.add_argument(
        "--out", type=other_file, help="file for the map: levelled, synthetic, or the heights after the contact"
    )
    surface.add_argument("--figure", type=picture_file, help="picture to draw")
    add_contact_arguments(surface, test=False, modulus=False)
    contact = surface.add_argument_group("contact of a ball (the first body) with the map (the second body)")
    contact.add_argument("--load", type=force, help="normal force in N")
    contact.add_argument("--cycles", type=whole(1, 1000), default=1, help="times that the load is applied (default 1)")
    contact.add_argument(
        "--plastic-factor", type=plain, help="c_h: fully plastic pressure over hardness (default: 0.71, of aluminium)"
    )
    contact.add_argument("--plastic-ratio", type=plain, help="c_A: 2 ω2/ω1 of a sphere (default: 160, of aluminium)")
    contact.add_argument(
        "--table",
        type=table_file,
        help="file for the law of the map as a table with `hertz` unloading, for YADE, LIGGGHTS and LAMMPS (others: "
        "demlaws table --law asperity --option surface=FILE)",
    )
    synthetic = surface.add_argument_group("synthetic map; --roughness is its Sq (default 1um)")
    synthetic.add_argument("--size", type=whole(4, 8192), default=512, help="pixels along each side (default 512)")
    synthetic.add_argument("--hurst", type=plain, default=0.8, help="Hurst exponent H = 3 - Df (default 0.8)")
    synthetic.add_argument("--seed", type=whole(0, 2**63), default=1, help="seed of the random numbers (default 1)")
    synthetic.add_argument("--longest", type=length, default=float("inf"), help="longest wavelength (default: no roll-off)")


def run(arguments, result):
    """Do what the command's arguments ask."""
    from demlaws.surface import write

    commands = {"synthetic": _synthetic, "contact": _contact, "summits": _summits}
    first, *rest = arguments.words
    command, paths = (commands[first], rest) if first in commands else (_levelled, arguments.words)
    if len(paths) != (command is not _synthetic):
        raise DemlawsError(f"one height map at a time, and none for synthetic, got {' '.join(arguments.words)}")
    heights = command(arguments, result, *paths)
    if command in (_levelled, _synthetic):
        _describe(result, heights, arguments.wavelengths)
    if arguments.out is not None:
        result.print(write(arguments.out, heights))
    draw(result, arguments.figure, lambda plots: plots.surface.surface_figure(heights, arguments.wavelengths))


def _levelled(arguments, result, path):
    """The map of a file, cropped, without spikes and without form, as the options ask; prints the form."""
    from demlaws import surface
    from demlaws.surfaces import plausibility

    heights, scale = surface.read_unchecked(
        path, arguments.pixel, arguments.unit, missing=arguments.missing, channel=arguments.channel
    )
    if arguments.crop is not None:
        heights = heights.cropped(arguments.crop)
    if arguments.despike:
        clean = heights.despiked()
        count = round((clean.missing - heights.missing) * heights.heights.size)
        result.values["despiked"] = count
        result.print(f"{count} pixels were spikes or fillers and are now missing")
        heights = clean
    _warn(result, plausibility.doubts(heights, scale))
    first, second = heights.radii_of_curvature()
    kind = "a cap" if min(first, second) > 0.0 else "a hollow" if max(first, second) < 0.0 else "a saddle"
    text = f"form before levelling: {kind} with radii of curvature {first * 1e3:.4g} and {second * 1e3:.4g} mm"
    if first * second > 0.0 and math.isfinite(first * second):
        text += f", √(R1 R2) = {math.sqrt(first * second) * 1e3:.4g} mm"
    result.print(text)
    return heights if arguments.form == -1 else heights.without_form(arguments.form)


def _warn(result, found):
    """Print and record reasons to doubt a map."""
    from demlaws.surfaces import plausibility

    result.values["doubts"] = [*result.values.get("doubts", []), *found]
    plausibility.warn_of_map(found)


def _summits(arguments, result, path):
    from demlaws.solvers.summits import summits
    from demlaws.surfaces import plausibility

    heights = _levelled(arguments, result, path)
    sample = summits(heights)
    result.values |= {name: getattr(sample, name) for name in ("total", "density", "radius", "height", "spread")}
    result.print(
        f"{sample.total} nine-point summits on {heights.field_of_view[0] * 1e6:.4g} x {heights.field_of_view[1] * 1e6:.4g} µm, "
        f"pixels of {heights.pixel_x * 1e6:.4g} µm: η = {sample.density * 1e-12:.4g} /µm²"
    )
    result.print(
        f"β = {sample.radius * 1e6:.4g} µm (one over the mean curvature), "
        f"summits {sample.height * 1e6:.4g} µm above the mean plane, rms {sample.spread * 1e6:.4g} µm; "
        f"Sq = {sample.roughness * 1e6:.4g} µm"
    )
    if arguments.effective_radius is not None:
        _warn(result, plausibility.field_doubts(heights, arguments.effective_radius))
        result.print(
            f"μ = (8/3) η σ √(2Rβ) = {sample.mu(arguments.effective_radius):.4g} for "
            f"R = {arguments.effective_radius * 1e3:g} mm and σ = Sq"
        )
    return heights


def _describe(result, heights, wavelengths):
    from demlaws.surfaces import plausibility

    names = ("field_of_view", "missing", "sq", "sa", "slope", "form_order", "robust_sq")
    result.values |= {"pixels": heights.shape[::-1]} | {name: getattr(heights, name) for name in names}
    rows, columns = heights.shape
    width, height = heights.field_of_view
    result.print(
        f"{columns} x {rows} pixels of {heights.pixel_x * 1e6:.4g} x {heights.pixel_y * 1e6:.4g} µm; "
        f"field of view {width * 1e6:.4g} x {height * 1e6:.4g} µm; {100 * heights.missing:.3g} % missing"
    )
    form = {None: "none", "sphere": "sphere"}.get(heights.form_order, f"polynomial of order {heights.form_order}")
    result.print(f"form removed: {form}")
    result.print(
        f"Sq = {heights.sq * 1e6:.4g} µm (robust, by the median: {heights.robust_sq * 1e6:.4g} µm), "
        f"Sa = {heights.sa * 1e6:.4g} µm, rms slope {heights.slope:.4g}"
    )
    if heights.sq == 0:
        return
    found = {}
    for name, method in (
        ("box counting, calibrated", heights.fractal_dimension_by_boxes),
        ("plain box counting", lambda range: heights.fractal_dimension_by_boxes(range, plain=True)),
        ("spectrum", heights.fractal_dimension_by_spectrum),
    ):
        try:
            found[name] = dimension = method(wavelengths)
            result.values[f"fractal_dimension_by_{name.replace(', ', '_').replace(' ', '_')}"] = dimension
            result.print(f"fractal dimension by {name}: Df = {dimension:.3f}")
        except DemlawsError as error:
            result.print(f"fractal dimension by {name}: none ({error})")
    _warn(result, plausibility.dimension_doubts(found.get("box counting, calibrated"), found.get("spectrum")))


def _synthetic(arguments, result):
    from demlaws.surface import self_affine

    if arguments.out is None:
        raise DemlawsError("--out missing: name the file (.npy, .csv or .asc) for the synthetic map")
    return self_affine(
        arguments.size,
        arguments.pixel or 1e-6,
        arguments.hurst,
        roughness=(arguments.roughness or [1e-6])[0],
        seed=arguments.seed,
        longest=arguments.longest,
    )


def _contact(arguments, result, name):
    from demlaws.regime import regime
    from demlaws.solvers.contact import RoughContact
    from demlaws.surfaces.plausibility import resolution_doubts

    bodies = bodies_from(arguments)
    if bodies is None:
        raise DemlawsError("--young and --poisson (or --material) missing: give those of the ball and of the map's body")
    if arguments.load is None and arguments.table is None:
        raise DemlawsError("--load missing: the load in N (or --table, for the law alone)")
    heights = _levelled(arguments, result, name)
    material = bodies[1].poisson, arguments.plastic_factor, arguments.plastic_ratio
    contact = RoughContact(heights, contact_from(arguments, sigma=heights.sq), *material)
    if arguments.table is not None:
        _table(arguments, result, contact)
    if arguments.load is None:
        return heights
    _warn(result, resolution_doubts(contact.heights, contact.pair, arguments.load))
    if contact.pair.hardness is not None:
        result.print(regime(contact.pair, arguments.load))
    step, worn = _cycles(arguments, result, contact)
    result.print(step)
    result.values |= {"contact": contact.pair, "force": arguments.load, "text": str(step).splitlines()}
    result.values["micro_contacts"] = len(step.micro)
    return worn.heights


def _cycles(arguments, result, contact):
    """The step of the first loading of the command, and the contact after the last; prints how much each cycle changes."""
    steps, changes = [], []
    for _ in range(arguments.cycles):
        steps.append(contact.load(arguments.load))
        worn = contact.unload(steps[-1])
        changes.append(worn.change_from(contact))
        contact = worn
    result.values["cycles"] = [{"area": s.contact_area, "change": c} for s, c in zip(steps, changes, strict=True)]
    for number, (step, change) in enumerate(zip(steps, changes, strict=True), 1):
        share = f", {change / changes[0]:.2g} of the first" if number > 1 and changes[0] > 0.0 else ""
        result.print(
            f"cycle {number}: area {step.contact_area * 1e12:.5g} µm², change of the map {change * 1e18:.4g} µm³{share}"
        )
    return steps[0], contact


def _table(arguments, result, contact):
    from demlaws.make import law

    bound = law(
        ASPERITY,
        contact.pair,
        "hertz",
        surface=contact.heights,
        poisson=contact.poisson,
        plastic_factor=contact.plastic_factor,
        plastic_ratio=contact.plastic_ratio,
    )
    table = bound.tabulate()
    table.save(arguments.table)
    result.values |= {name: getattr(table, name) for name in ("force_error", "stiffness_error")}
    result.values["table"] = str(arguments.table)
    result.print(
        f"{arguments.table}: law asperity (hertz unloading), {table.nodes.u.size} rows, "
        f"error of force {table.force_error:.1e}, of stiffness {table.stiffness_error:.1e}"
    )
