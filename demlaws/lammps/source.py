"""The models as sources of LAMMPS: files that are copied into src/GRANULAR. Only the standard library."""

from pathlib import Path
from typing import NamedTuple

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


class Written(NamedTuple):
    """Files that were written; `register`: the file of LAMMPS that `ROWS` are still to be added to, or None."""

    files: tuple
    register: Path | None

    def __str__(self):
        lines = [f"wrote {file}" for file in self.files]
        if self.register:
            lines += [f"add to {self.register}, the first line to its includes, the others to its table:", ROWS.rstrip()]
        else:
            lines.append(
                "now configure and build LAMMPS with package GRANULAR: cmake -D PKG_GRANULAR=on ..., or make yes-granular"
            )
        return "\n".join(lines)


def source(folder):
    """Write the files into `folder`, LAMMPS's src/GRANULAR, and return `Written`; earlier ones are replaced.

    For releases from 4 Feb 2025 on. LAMMPS then has the models without any plugin, also as a static executable, and reads the
    inputs of the plugin and its restart files.
    """
    head = f"// The models of demlaws {demlaws.__version__}, written by `demlaws lammps source`. Licence: GPL-2.0-or-later."
    texts = {name: (SOURCES / name).read_text() for name in COPIED}
    texts[MODELS] = "\n".join([head, *inlined("granular_models.h", FOLDERS, COPIED)]) + "\n"
    files = write_sources(folder, texts, "granular_model.h")
    register = Path(folder) / REGISTER
    missing = register.is_file() and "gran_sub_mod_demlaws.h" not in register.read_text()
    return Written(files, register if missing else None)
