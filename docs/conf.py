"""The site: `make docs`. Generated pages are written to docs/made first (making/pages.py)."""

import datetime
import platform
import struct
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent)]

from docutils import nodes  # noqa: E402
from making import links, pages  # noqa: E402

import demlaws  # noqa: E402

project = "demlaws"
author = "demlaws authors"
version = release = demlaws.__version__
copyright = f"{datetime.date.today().year}, {author}; GPL-2.0-or-later"
extensions = ["sphinx.ext.autodoc", "sphinx.ext.autosummary", "myst_parser", "making.formula", "making.docstrings"]
html_theme = "furo"
html_title = f"demlaws {version}"
html_math_renderer = "mathml"
html_copy_source = False
html_show_sphinx = False
html_static_path = ["making/static"]
html_css_files = ["site.css"]
html_theme_options = {"footer_icons": []}
exclude_patterns = ["making", "inside", "gallery", "theory/notes", "README.md", "paper.md", "results/*"]
exclude_patterns += ["validation/report.md", "validation/claims.md"]  # parts of validation/index.md
myst_heading_anchors = 4
myst_enable_extensions = ["colon_fence"]
suppress_warnings = ["misc.highlighting_failure", "myst.header"]
highlight_language = "none"
autosummary_generate = False
autodoc_member_order = "bysource"
autodoc_typehints = "none"
add_module_names = False
nitpicky = False

LISTS = pages.write()
LISTS["BUILT"] = (
    f"{datetime.date.today().isoformat()}, demlaws {version}, Python {platform.python_version()}, {platform.machine()}"
)


def source_read(app, name, source):
    """Insert what is made of records, and rewrite links to files that are elsewhere on the site."""
    text = source[0]
    for key, made in LISTS.items():
        text = text.replace(f"{{{{{key}}}}}", made)
    if not name.startswith("made/"):
        text = links.relinked(text, f"docs/{name}.md", f"{name}.md")
    if name.startswith("tutorials/"):
        file = f"../made/notebooks/{name.partition('/')[2]}"
        text += f"\n\nDownload this page as {{download}}`a notebook <{file}.ipynb>` or {{download}}`a script <{file}.sh>`.\n"
    source[0] = text


def outdated(app, env, added, changed, removed):
    """Pages with made parts are always read again."""
    return ["index", "laws", "install", "bibliography", "theory/contact", "validation/index"]


def doctree_read(app, doctree):
    """On a narrow screen pictures of one column have its width, rows of panels 40 em, others a height (site.css)."""
    for image in doctree.findall(nodes.image):
        if image["uri"].endswith(".png"):
            width, height = struct.unpack(">II", (HERE / image["uri"]).read_bytes()[16:24])
            if width > 1100 and height > 0.6 * width:
                image["classes"].append("rows")
            elif height > width:
                image["classes"].append("column")


def setup(app):
    """Sphinx calls this."""
    app.connect("source-read", source_read)
    app.connect("env-get-outdated", outdated)
    app.connect("doctree-read", doctree_read)
