"""demlaws: contact laws of rough and yielding grains for the discrete element method."""

import sys

if sys.version_info < (3, 10):  # noqa: UP036  before any module that such a Python cannot read
    _OLD = f"demlaws needs Python 3.10 or later, this is {sys.version_info[0]}.{sys.version_info[1]} ({sys.executable})"
    raise SystemExit(_OLD) if sys.argv[:1] == ["-m"] else ImportError(_OLD)

from demlaws.lazy import load_lazily

TYPE_CHECKING = False  # type checkers and editors take it for true; importing typing would take a third of the import time
if TYPE_CHECKING:
    from demlaws import driver as driver, materials as materials, plots as plots, surface as surface
    from demlaws.advice.choose import choose as choose
    from demlaws.advice.fit import fit as fit
    from demlaws.advice.scene import Scene as Scene
    from demlaws.advice.soften import soften as soften
    from demlaws.contact import Contact as Contact, Material as Material, Surface as Surface
    from demlaws.errors import DemlawsError as DemlawsError, ValidityWarning as ValidityWarning
    from demlaws.law import Law as Law, Table as Table
    from demlaws.laws.definition import Definition as Definition, Numbers as Numbers, Option as Option, Parameter as Parameter
    from demlaws.laws.registry import laws as laws, load_laws as load_laws, register as register
    from demlaws.make import law as law
    from demlaws.regime import RegimeFunctions as _RegimeFunctions
    from demlaws.shear import PressureFriction as PressureFriction
    from demlaws.timestep import TimestepFunctions as _TimestepFunctions
    from demlaws.user_laws.check import check_law as check_law
    from demlaws.user_laws.define import define as define

    regime: _RegimeFunctions
    timestep: _TimestepFunctions

__version__ = "0.3.0"

_HOMES = {
    "Contact": "demlaws.contact",
    "Definition": "demlaws.laws.definition",
    "DemlawsError": "demlaws.errors",
    "Law": "demlaws.law",
    "Material": "demlaws.contact",
    "Numbers": "demlaws.laws.definition",
    "Option": "demlaws.laws.definition",
    "Parameter": "demlaws.laws.definition",
    "PressureFriction": "demlaws.shear",
    "Scene": "demlaws.advice.scene",
    "Surface": "demlaws.contact",
    "Table": "demlaws.law",
    "ValidityWarning": "demlaws.errors",
    "check_law": "demlaws.user_laws.check",
    "choose": "demlaws.advice.choose",
    "define": "demlaws.user_laws.define",
    "driver": "demlaws.driver",
    "fit": "demlaws.advice.fit",
    "law": "demlaws.make",
    "laws": "demlaws.laws.registry",
    "load_laws": "demlaws.laws.registry",
    "materials": "demlaws.materials",
    "plots": "demlaws.plots",
    "regime": "demlaws.regime",
    "register": "demlaws.laws.registry",
    "soften": "demlaws.advice.soften",
    "surface": "demlaws.surface",
    "timestep": "demlaws.timestep",
}
"""Public name → the module that it is loaded from on first use: numba is imported with the first law."""

__all__ = sorted(_HOMES)

load_lazily(__name__, _HOMES)
