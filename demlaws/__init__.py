"""demlaws: contact laws of rough and yielding grains for the discrete element method."""

from demlaws import driver
from demlaws.choose import Scene, choose
from demlaws.contact import Contact, Material, Surface
from demlaws.driver import timestep
from demlaws.errors import DemlawsError, ValidityWarning
from demlaws.fit import fit
from demlaws.law import Law, law, laws
from demlaws.table import Table

__version__ = "0.1.0"

__all__ = [
    "Contact",
    "DemlawsError",
    "Law",
    "Material",
    "Scene",
    "Surface",
    "Table",
    "ValidityWarning",
    "choose",
    "driver",
    "fit",
    "law",
    "laws",
    "timestep",
]
