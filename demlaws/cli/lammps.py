"""`demlaws lammps build | check | export | run`."""

from demlaws.cli.arguments import force
from demlaws.cli.engine import register_engine


def register(subparsers):
    """Add the sub-command and its own sub-commands."""
    export = register_engine(
        subparsers,
        "lammps",
        "LAMMPS",
        builds="path of the plugin; compiles it if need be",
        forces="compile even if the wheel or the cache has it",
    )
    export.add_argument("--load", type=force, default=10.0, help="largest expected contact force [N] (default %(default)g)")
