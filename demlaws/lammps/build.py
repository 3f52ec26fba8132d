"""The plugin of LAMMPS: the one that the wheel brings, or one compiled into the cache. Only the standard library."""

import sys
from pathlib import Path

from demlaws.plugins.engines import Plugin, compiler

PACKAGED = Path(__file__).parent / "lib"
"""Where the wheel has the plugin, compiled for any processor, and the digest of the sources that it was made of."""


class _Plugin(Plugin):
    """LAMMPS loads what ends in plugin.so from the folders of LAMMPS_PLUGIN_PATH; nothing of LAMMPS or MPI is linked."""

    engine, file, source = "lammps", "demlawsplugin.so", "demlaws_lammps.cpp"
    sources = Path(__file__).parent / "src"
    packages = "sudo apt install g++, or install demlaws from a wheel, which has the plugin"
    flags = (*Plugin.flags, "-fvisibility=hidden", "-s")

    def links(self):
        return [f"-Wl,--version-script={self.sources / 'export.map'}", "-Wl,-z,nodelete", "-Wl,--no-undefined", "-ldl"]


PLUGIN = _Plugin()
library_path = PLUGIN.library_path


def packaged():
    """The wheel's plugin, or None: it is missing or was compiled from other sources."""
    library, digest = PACKAGED / PLUGIN.file, PACKAGED / "sources"
    try:
        if library.is_file() and digest.read_text().strip() == PLUGIN.source_digest():
            return library
    except OSError:
        pass
    return None


def build(portable=False, rebuild=False):
    """Path of the plugin's shared object; compiled (5 s) unless the cache or the wheel has it, see `engines.Plugin`.

    portable: for any processor of this kind; where the wheel brings that one, it is taken, and also without a compiler.
    """
    library = None if rebuild or (compiler() and not portable) else packaged()
    return library or PLUGIN.build(portable, rebuild)


def plugin_folder():
    """Folder of the plugin, for LAMMPS's entry point `lammps.plugins`: what it names is loaded whenever `lmp` starts.

    Never raises, for that would keep LAMMPS from starting: without a plugin a folder without one, and a line with the reason.
    """
    try:
        return str((packaged() or build()).parent)
    except Exception as error:
        print(f"demlaws: no plugin for LAMMPS: {error}", file=sys.stderr)
        return str(PACKAGED)
