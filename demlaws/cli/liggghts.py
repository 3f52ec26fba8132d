"""`demlaws liggghts build | check | export | run`."""

from demlaws.cli.arguments import force
from demlaws.cli.engine import register_engine

WITHOUT_COMPILER = """
without a compiler:
  demlaws liggghts export case --stock hertz --load 10 --radius 0.004 --sq 1.7e-6 --fractal-dimension 2.22"""


def register(subparsers):
    """Add the sub-command and its own sub-commands."""
    export = register_engine(
        subparsers,
        "liggghts",
        "LIGGGHTS",
        builds="compile the plugin, print its path",
        forces="compile even if the cache has it",
        more=WITHOUT_COMPILER,
        words=lambda arguments: {"stock": arguments.stock},
    )
    export.add_argument("--stock", choices=("hertz", "edinburgh"), help="fit this stock model instead; needs no compiler")
    export.add_argument("--load", type=force, help="contact force [N] of the fit, and the largest expected (default 10)")
