"""`demlaws regime` (which part deforms) and `demlaws surface` (height maps, their contact, their law)."""

import dataclasses
from pathlib import Path

from demlaws.cli import example
from demlaws.cli.arguments import force, length, output, plain, pressure, whole
from demlaws.cli.curve import SIGMA
from demlaws.cli.refused import Refused
from demlaws.errors import DemlawsError


def register(subparsers):
    regime = subparsers.add_parser(
        "regime",
        description="The criterion of Jamari & Schipper: p(0)/H_m at a load, the load at which the answer changes, which laws "
        "fit. Without a contact: the published tests.",
        **example(
            "  demlaws regime --figure regime.png\n"
            "  demlaws regime --radius 3.175mm --young 75.2e9 --poisson 0.34 --hardness 0.24e9 --ball-young 430e9 \\\n"
            "      --ball-poisson 0.17 --sigma 1.3um --load 0.2"
        ),
    )
    _bodies(regime)
    regime.add_argument("--sigma", dest="roughness", type=length, help="combined rms roughness σ in m, or with a unit: 1.3um")
    regime.add_argument("--roughness", action=Refused, remedy=SIGMA)
    regime.add_argument("--fractal-dimension", type=plain, help="Df from 2 to 3")
    regime.add_argument("--load", type=force, help="load in N")
    regime.add_argument("--mu", type=plain, help="Greenwood & Tripp's μ of the surface: p(0) from their solution, not the fit")
    regime.add_argument(
        "--yield-pressure", type=pressure, help="measured limit pressure p_y in Pa, in place of 0.6 of the hardness"
    )
    regime.add_argument("--figure", type=output, help="map of p(0)/H_m over load and roughness")
    regime.set_defaults(func=run_regime)

    surface = subparsers.add_parser(
        "surface",
        usage="demlaws surface FILE [options]\n"
        "       demlaws surface contact FILE [options]\n"
        "       demlaws surface contact isotropic|anisotropic [options]\n"
        "       demlaws surface synthetic --out FILE [options]",
        description="FILE: .npy, .csv, .txt, .tsv or .asc, or what an instrument writes (through SurfaceTopography). The first "
        "form levels a map and prints its roughness; `contact` presses a smooth ball on it; `contact isotropic` and `contact "
        "anisotropic` repeat the tests of Jamari & Schipper 2008; `synthetic` makes a self-affine map.",
        **example(
            "  demlaws surface synthetic --size 512 --pixel 0.5um --hurst 0.8 --sq 1.3um --seed 1 --out map.asc\n"
            "  demlaws surface map.asc --form 2 --figure map.png\n"
            "  demlaws surface contact map.asc --radius 3.175mm --young 75.2e9 --poisson 0.34 --hardness 0.24e9 \\\n"
            "      --ball-young 430e9 --ball-poisson 0.17 --load 0.2 --cycles 20 --table map.tbl --figure contact.png"
        ),
    )
    surface.add_argument("words", nargs="+", metavar="FILE", help="see above")
    surface.add_argument("--pixel", help="pixel size, for files that do not say it: 0.8um, or 0.8um,1um for x and y")
    surface.add_argument("--unit", default="m", help="unit of the heights in a text or .npy file (default m)")
    surface.add_argument("--form", type=whole(-1, 8), help="order of the polynomial removed (default 2; -1: none)")
    surface.add_argument(
        "--wavelengths", type=length, nargs=2, metavar=("SHORTEST", "LONGEST"), help="range of the fractal dimension's fits"
    )
    surface.add_argument("--out", type=output, help="write the map: levelled, synthetic, or as the last cycle leaves it")
    surface.add_argument("--figure", type=output, help="picture to draw")
    contact = surface.add_argument_group("contact")
    _bodies(contact)
    contact.add_argument("--flat", action="store_true", help="press with a smooth flat in place of a ball")
    contact.add_argument("--on", metavar="FILE", help="height map of the other body: both are rough")
    contact.add_argument("--load", type=force, help="load in N (default 0.2 for the published tests)")
    contact.add_argument("--cycles", type=whole(1, 100_000), default=1, help="number of load cycles (default 1)")
    contact.add_argument("--tolerance", type=plain, default=0.01, help="relative tolerance of the load (default 0.01)")
    contact.add_argument(
        "--plastic-factor", type=plain, help="c_h: fully plastic pressure over hardness (without: aluminium's)"
    )
    contact.add_argument(
        "--memory",
        choices=("pressure", "blunting", "none"),
        default="pressure",
        help="what unloading leaves in a pixel besides its height; an assumption: with none, geometry alone, nothing runs in",
    )
    contact.add_argument("--plastic-ratio", type=plain, help="c_A: 2 ω2/ω1 of a sphere (without: aluminium's)")
    contact.add_argument("--csv", type=output, help="write the micro-contacts of the first cycle")
    contact.add_argument("--table", type=output, help="write the map's law as a table for YADE and LIGGGHTS")
    contact.add_argument("--curve", choices=("loading", "reloading"), default="loading", help="which curve the table holds")
    contact.add_argument("--unloading", default="hertz", help="rule joined to the table (default hertz; reloading: elastic)")
    contact.add_argument("--max-force", type=force, help="end of the computed curve in N")
    contact.add_argument("--rtol", type=plain, default=1e-5, help="relative tolerance of the table (default 1e-5)")
    made = surface.add_argument_group("synthetic")
    made.add_argument("--size", type=whole(4, 8192), default=512, help="pixels along each side (default 512)")
    made.add_argument("--hurst", type=plain, default=0.8, help="Hurst exponent H = 3 - Df (default 0.8)")
    made.add_argument("--sq", dest="roughness", type=length, default=1e-6, help="rms roughness Sq of the map (default 1um)")
    made.add_argument("--roughness", action=Refused, remedy="give --sq, the map's own Sq")
    made.add_argument("--seed", type=whole(0, 2**63), default=1, help="seed of the random numbers (default 1)")
    made.add_argument("--shortest", type=length, default=0.0, help="shortest wavelength (default: two pixels)")
    made.add_argument("--longest", type=length, default=float("inf"), help="longest wavelength (default: no roll-off)")
    made.add_argument("--anisotropy", type=plain, default=1.0, help="how much longer along x (default 1)")
    surface.set_defaults(func=run_surface)


def _bodies(parser):
    parser.add_argument("--radius", type=length, help="radius of the ball in m, or with a unit: 3.175mm")
    parser.add_argument("--rough-radius", type=length, default=float("inf"), help="radius of the rough body (default: flat)")
    parser.add_argument("--young", type=pressure, help="Young's modulus of the rough body in Pa")
    parser.add_argument("--poisson", type=plain, help="its Poisson's ratio")
    parser.add_argument("--hardness", type=pressure, help="its hardness in Pa (without: elastic asperities)")
    parser.add_argument("--ball-young", type=pressure, help="Young's modulus of the ball (default: as the rough body)")
    parser.add_argument("--ball-poisson", type=plain, help="its Poisson's ratio")


def _pair(arguments, roughness, fractal_dimension=None):
    from demlaws.contact import Contact, Material

    missing = [f"--{n}" for n in ("radius", "young", "poisson") if getattr(arguments, n) is None]
    if missing:
        raise DemlawsError(f"{', '.join(missing)} missing: give the ball's radius and the rough body's material")
    if (arguments.ball_young is None) != (arguments.ball_poisson is None):
        raise DemlawsError("--ball-young and --ball-poisson belong together")
    rough = Material(arguments.young, arguments.poisson, arguments.hardness)
    ball = rough if arguments.ball_young is None else Material(arguments.ball_young, arguments.ball_poisson)
    return Contact.between(
        ball,
        rough,
        radius1=arguments.radius,
        radius2=arguments.rough_radius,
        roughness2=roughness,
        fractal_dimension=fractal_dimension,
    )


def run_regime(arguments):
    from demlaws import regime

    given = [n for n in ("radius", "young", "poisson", "hardness", "roughness", "load") if getattr(arguments, n) is not None]
    if not given:
        return _published(arguments)
    for name, flag in (("roughness", "sigma"), ("hardness", "hardness")):
        if getattr(arguments, name) is None and not (name == "hardness" and arguments.yield_pressure is not None):
            raise DemlawsError(f"--{flag} missing: the criterion needs it")
    pair = _pair(arguments, arguments.roughness, arguments.fractal_dimension)
    if arguments.load is None:
        print(f"the bulk yields (p(0)/H_m = {regime.YIELD_RATIO}) from {regime.transition_load(pair):.4g} N; below, asperities")
    else:
        print(regime.assess(pair, arguments.load, arguments.mu, arguments.yield_pressure))
        print("laws at this load:")
        for advice in regime.advise(pair, arguments.load, arguments.yield_pressure):
            print(f"  {advice.law:16} {'fits' if advice.fits else 'no'}: {advice.reason}")
    _draw(arguments.figure, lambda plots: plots.regime_figure(pair, arguments.load))
    return 0


def _published(arguments):
    from demlaws import regime

    rows = regime.published_ratios()
    print(f"{'':18} {'':6} {'':7} {'α':>7} {'':>8} {'μ':>8} {'p(0)/H_m':>23}")
    print(
        f"{'test':18} {'P (N)':>6} {'σ (µm)':>7} {'comp.':>7} {'printed':>8} {'printed':>8} "
        f"{'at μ':>7} {'Eq. 4':>7} {'printed':>8}  seen"
    )

    def cell(value, text):
        return f"{'-':>{len(format(1.0, text))}}" if value != value else format(value, text)

    for row in rows:
        test = row.test
        print(
            f"{test.label:18} {test.load:6g} {test.contact.roughness * 1e6:7.2f} {row.alpha:7.2f} {cell(test.alpha, '8.2f')} "
            f"{cell(test.mu, '8.0f')} {cell(row.solved, '7.3f')} {row.fitted:7.3f} {cell(test.ratio, '8.2f')}  {test.seen}"
        )
    print("\nat μ: Greenwood & Tripp's solution at the printed μ, the paper's own method; Eq. 4: its closed fit; both computed")
    for column, name in (("solved", "by the solution"), ("fitted", "by Eq. 4")):
        count = regime.swaps(rows, column)
        order = "the order is that of what was seen" if not count else f"{count} of the tests of 2006 stands out of order"
        print(f"  {name}: {order}")
    _draw(arguments.figure, lambda plots: plots.regime_figure())
    return 0


def _draw(path, make):
    if path is not None:
        from demlaws import plots
        from demlaws.plots import surface as plots_surface

        print(plots.save(make(plots_surface), path))


def run_surface(arguments):
    first, *rest = arguments.words
    if first == "synthetic" and not rest:
        return _synthetic(arguments)
    if first == "contact":
        if len(rest) != 1:
            raise DemlawsError("`demlaws surface contact` takes one height map (or isotropic, anisotropic)")
        return _contact(arguments, rest[0])
    if rest:
        raise DemlawsError(f"one height map at a time, got {' '.join(arguments.words)}")
    heights = _levelled(arguments, first)
    _describe(heights, arguments.wavelengths)
    _write(arguments.out, heights)
    _draw(arguments.figure, lambda plots: plots.surface_figure(heights, arguments.wavelengths))
    return 0


def _levelled(arguments, path):
    from demlaws import surface

    heights = surface.read(path, arguments.pixel, arguments.unit)
    order = 2 if arguments.form is None else arguments.form
    return heights if order == -1 else heights.without_form(order)


def _describe(heights, wavelengths):
    rows, columns = heights.shape
    width, height = heights.field_of_view
    print(f"{columns} x {rows} pixels of {heights.pixel_x * 1e6:.4g} x {heights.pixel_y * 1e6:.4g} µm", end="; ")
    print(f"field of view {width * 1e6:.4g} x {height * 1e6:.4g} µm; {100 * heights.missing:.3g} % missing")
    form = "none" if heights.form_order is None else f"polynomial of order {heights.form_order}"
    print(f"form removed: {form}")
    print(f"Sq = {heights.sq * 1e6:.4g} µm, Sa = {heights.sa * 1e6:.4g} µm, rms slope {heights.slope:.4g}")
    if heights.sq == 0:
        return
    for name, method in (
        ("box counting", heights.fractal_dimension_by_boxes),
        ("spectrum", heights.fractal_dimension_by_spectrum),
    ):
        try:
            print(f"fractal dimension by {name}: Df = {method(wavelengths):.3f}")
        except DemlawsError as error:
            print(f"fractal dimension by {name}: none ({error})")


def _write(path, heights):
    if path is not None:
        from demlaws import surface

        print(surface.write(path, heights))


def _synthetic(arguments):
    from demlaws.surface import self_affine

    if arguments.out is None:
        raise DemlawsError("--out missing: name the file (.npy, .csv or .asc) for the synthetic map")
    heights = self_affine(
        arguments.size,
        arguments.pixel or 1e-6,
        arguments.hurst,
        arguments.roughness,
        arguments.seed,
        shortest=arguments.shortest,
        longest=arguments.longest,
        anisotropy=arguments.anisotropy,
    )
    _describe(heights, arguments.wavelengths)
    _write(arguments.out, heights)
    _draw(arguments.figure, lambda plots: plots.surface_figure(heights, arguments.wavelengths))
    return 0


def _contact(arguments, name):
    from demlaws import regime
    from demlaws.solvers import patches as asperity

    published = name in ("isotropic", "anisotropic") and not Path(name).exists()
    if published:
        contact = asperity.published_contact(name, memory=arguments.memory)
        load, cycles = arguments.load or 0.2, max(arguments.cycles, 20)
    else:
        heights = _levelled(arguments, name)
        if arguments.on is not None:
            heights = heights.combined(_levelled(arguments, arguments.on))
        pair = _pair(arguments, heights.sq)
        contact = asperity.RoughContact(
            heights,
            pair,
            arguments.poisson,
            arguments.plastic_factor,
            arguments.plastic_ratio,
            flat=arguments.flat,
            memory=arguments.memory,
        )
        load, cycles = arguments.load, arguments.cycles
    if load is None and arguments.table is None:
        raise DemlawsError("--load missing: the load in N (or --table, for the law alone)")
    if load is not None:
        if contact.pair.hardness is not None and not arguments.flat:
            print(regime.assess(contact.pair, load))
        tolerance = min(arguments.tolerance, 1.0)
        history = asperity.repeat(contact, load, cycles, tolerance, keep=(1, 2, 3, 10, cycles))
        others = {}
        if cycles > 1 and contact.pair.hardness is not None:
            few = min(cycles, 5)
            for memory in asperity.MEMORIES:
                if memory != contact.memory:
                    other = dataclasses.replace(contact, memory=memory)
                    others[memory] = asperity.repeat(other, load, few, tolerance, keep=())
        for cycle in history:
            if cycle.number in (1, 2, 3, 10, cycles):
                print(f"cycle {cycle.number}: {cycle.step}; change of the map {cycle.relative_change:.3g} of the first")
        print(
            f"run in after cycle {max(asperity.run_in_cycle(history), 1)} (ε_r = 0.01), on the assumption that a pixel "
            f"remembers {asperity.REMEMBERED[contact.memory]} (--memory {contact.memory})"
        )
        for memory, few in others.items():
            print(
                f"  with --memory {memory} cycle 2 changes the map by {100 * few[1].relative_change:.2g} % of cycle 1's change"
            )
        if arguments.csv is not None:
            _write_micro_contacts(arguments.csv, history[0].step.micro)
        _write(arguments.out, history[-1].contact.heights)
        _draw(
            arguments.figure,
            lambda plots: (
                plots.repeated_figure(contact, history, name, others)
                if cycles > 1
                else plots.contact_figure(contact, history[0].step)
            ),
        )
    if arguments.table is not None:
        _table(arguments, contact, load)
    return 0


def _table(arguments, contact, load):
    from demlaws.make import law

    if arguments.flat:
        raise DemlawsError("--table: a law for DEM is that of a ball; leave out --flat")
    options = {"curve": arguments.curve} if arguments.curve == "loading" else {"curve": arguments.curve, "load": load}
    if arguments.curve == "reloading" and load is None:
        raise DemlawsError("--load missing: the reloading curve is the one after this load")
    if arguments.max_force is not None:
        options["max_force"] = arguments.max_force
    unloading = "elastic" if arguments.curve == "reloading" else arguments.unloading
    bound = law(
        "asperity",
        contact.pair,
        unloading,
        surface=contact.heights,
        poisson=contact.poisson,
        plastic_factor=contact.plastic_factor,
        plastic_ratio=contact.plastic_ratio,
        **options,
    )
    table = bound.tabulate(arguments.rtol)
    table.save(arguments.table)
    print(
        f"{arguments.table}: law asperity ({arguments.curve}, {unloading} unloading), {table.nodes.u.size} rows, "
        f"error of force {table.force_error:.1e}, of stiffness {table.stiffness_error:.1e}"
    )


def _write_micro_contacts(path, micro):
    from demlaws.files import write_atomically

    names = ("x", "y", "cut_area", "volume", "length_long", "length_short", "angle", "indentation", "force", "area", "state")
    lines = [",".join(names)]
    lines += [",".join(f"{value:.9g}" for value in row) for row in zip(*(getattr(micro, n) for n in names), strict=True)]
    print(f"{write_atomically(path, chr(10).join(lines) + chr(10))}: {len(micro)} micro-contacts")
