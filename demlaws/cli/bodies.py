"""A ball and a rough body on the command line, and the figures of both commands that press the one on the other."""

from demlaws.cli.arguments import length, plain, pressure
from demlaws.errors import DemlawsError


def bodies(parser):
    """Add the arguments that describe a ball and a rough body."""
    parser.add_argument("--radius", type=length, help="radius of the ball in m, or with a unit: 3.175mm")
    parser.add_argument("--rough-radius", type=length, default=float("inf"), help="radius of the rough body (default: flat)")
    parser.add_argument("--young", type=pressure, help="Young's modulus of the rough body in Pa")
    parser.add_argument("--poisson", type=plain, help="its Poisson's ratio")
    parser.add_argument("--hardness", type=pressure, help="its hardness in Pa (without: elastic asperities)")
    parser.add_argument("--ball-young", type=pressure, help="Young's modulus of the ball (default: as the rough body)")
    parser.add_argument("--ball-poisson", type=plain, help="its Poisson's ratio")


def pair_of(arguments, roughness, fractal_dimension=None):
    """Contact of the ball and the rough body, combined roughness `roughness` [m]. DemlawsError says what is missing."""
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


def draw(path, make):
    """Save the figure that `make(plots.surface)` returns, if a path was given; prints the path."""
    if path is not None:
        from demlaws import plots
        from demlaws.plots import surface as plots_surface

        print(plots.save(make(plots_surface), path))
