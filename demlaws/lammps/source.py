"""The models as sources of LAMMPS: files that are copied into src/GRANULAR. Only the standard library."""

from pathlib import Path

import demlaws
from demlaws.plugins.engines import SHARED, inlined, write_sources

SOURCES = Path(__file__).parent / "source"
FOLDERS = (SOURCES, Path(__file__).parent / "src", SHARED)
"""Where headers are looked for: those that include LAMMPS's own go before those that find LAMMPS by name."""
COPIED = ("compute_demlaws_energy.h", "fix_demlaws.h", "gran_sub_mod_demlaws.h", "gran_sub_mod_demlaws.cpp")
MODELS = "demlaws_models.h"
REGISTER = "gran_sub_mod_register.cpp"
"""Where LAMMPS has this file, sub-models are registered in it; until 4 Jul 2026 the build finds them by itself."""
ROWS = """\
#include "gran_sub_mod_demlaws.h"

  { "demlaws/table",          &creator<GranSubModNormalDemlaws>,                NORMAL },
  { "demlaws/tangent",        &creator<GranSubModDampingDemlaws>,               DAMPING },
  { "demlaws",                &creator<GranSubModTangentialDemlaws>,            TANGENTIAL },
"""


THEN = "now configure and build LAMMPS with package GRANULAR: cmake -D PKG_GRANULAR=on ..., or make yes-granular"


def source(folder):
    """Write the files into `folder`, LAMMPS's src/GRANULAR; earlier ones are replaced. Returns lines for the user.

    For releases from 4 Feb 2025 on. LAMMPS then has the models without any plugin, also as a static executable, and reads the
    inputs of the plugin and its restart files.
    """
    head = f"// The models of demlaws {demlaws.__version__}, written by `demlaws lammps source`. Licence: GPL-2.0-or-later."
    texts = {name: (SOURCES / name).read_text() for name in COPIED}
    texts[MODELS] = "\n".join([head, *inlined("granular_models.h", FOLDERS, COPIED)]) + "\n"
    register, then = Path(folder) / REGISTER, THEN
    if register.is_file() and "gran_sub_mod_demlaws.h" not in register.read_text():
        then = f"add to {register}, the first line to its includes, the others to its table:\n{ROWS.rstrip()}"
    return write_sources(folder, texts, "granular_model.h", then)
