"""demlaws: contact laws of rough and yielding grains for the discrete element method."""

from demlaws import driver
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
    "Surface",
    "Table",
    "ValidityWarning",
    "driver",
    "fit",
    "law",
    "laws",
    "timestep",
]
