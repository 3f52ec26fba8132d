"""Where the site shows files of the repository, and the links of a page that is shown elsewhere."""

import os
import re
from pathlib import Path

DOCS = Path(__file__).resolve().parents[1]
ROOT = DOCS.parent
MADE = DOCS / "made"

ELSEWHERE = {
    "yade_scripts/README.md": "made/yade.md",
    "README.md": "index.md",
    "CITATION.cff": "bibliography.md",
    "docs/validation/report.md": "validation/index.md#comparison-with-published-and-third-party-results",
    "docs/validation/claims.md": "validation/index.md#statements-of-the-granite-paper-tested",
}
"""Pages of the repository that are part of another page of the site, or outside docs/ → where the site shows them."""

INTERNAL = ("docs/inside/", "CONTRIBUTING.md")
"""For maintainers: in the repository only."""

LAWS = {
    f"demlaws/laws/{path.stem}.py": f"made/theory/{path.stem.replace('_', '-')}.md"
    for path in (ROOT / "demlaws" / "laws").glob("*.py")
}
"""A link to the file of a law leads to the page that is made of it; in the repository, to the file."""

LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\((?!\w+:)([^)#\s]*)(#[^)\s]*)?\)")


def relinked(text, source, target):
    """Links of `source` (a file of the repository) rewritten for the page `target` of docs/.

    A link to a file that the site has elsewhere leads there; other files are named, without a link.
    """

    def link(match):
        picture, words, path, anchor = match.groups()
        if not path:
            return match.group()
        real = Path(os.path.normpath((ROOT / source).parent / path))
        inside = real.relative_to(ROOT).as_posix() if real.is_relative_to(ROOT) else ""
        if inside in ELSEWHERE or (real / "README.md").relative_to(ROOT).as_posix() in ELSEWHERE if inside else False:
            shown = ELSEWHERE.get(inside) or ELSEWHERE[f"{inside}/README.md"]
        elif inside.startswith("docs/pictures/") and (MADE / "gallery" / real.name).exists():
            shown = f"made/gallery/{real.name}"  # drawn just now
        elif inside in LAWS and real.exists():
            shown = LAWS[inside]
        elif inside.startswith("docs/") and not inside.startswith(INTERNAL):
            shown = inside[len("docs/") :]
        elif real.exists():
            return f"{words} (`{inside}`)"
        else:
            raise ValueError(f"{source}: {path} does not exist")
        return f"{picture}[{words}]({os.path.relpath(DOCS / shown, (DOCS / target).parent)}{anchor or ''})"

    return LINK.sub(link, text)
