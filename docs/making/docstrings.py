"""Docstrings of the package, plain text, as reStructuredText: stars and bars are escaped, `x` is code."""

import re

SECTION = re.compile(r"-{4,}")
LEFT_OUT = re.compile(r"^(?:Raises|Examples|See Also)\n-+\n.*?(?=^\S[^\n]*\n---|\Z)", re.MULTILINE | re.DOTALL)
"""Sections that the page leaves to `help()`; its first lines name the error of inadmissible input."""


def _prose(line):
    pieces = line.split("`")
    out = []
    for number, piece in enumerate(pieces):
        if number % 2 and number < len(pieces) - 1:
            before = "\\ " if pieces[number - 1][-1:].isalnum() else ""
            after = "\\ " if pieces[number + 1][:1].isalnum() else ""
            out.append(f"{before}``{piece}``{after}" if piece.strip() == piece and piece else piece)
        else:
            out.append(re.sub(r"([\\*|]|_\b)", r"\\\1", piece))
    return "".join(out)


def _blocks(lines):
    block = []
    for line in [*lines, ""]:
        if line.strip():
            block.append(line.rstrip())
        elif block:
            yield block
            block = []


def restructured(lines):
    """Lines of a docstring as reStructuredText: running text, indented lines as they stand, examples as they are."""
    out = []
    for block in _blocks(lines):
        first = len(block[0]) - len(block[0].lstrip())
        if block[0].lstrip().startswith(">>>"):
            out += [line[first:] for line in block]
        elif first:
            low = min(len(line) - len(line.lstrip()) for line in block)
            out += ["::", "", *("    " + line[low:] for line in block)]
        else:
            cut = next((i for i, line in enumerate(block) if line.lstrip().startswith(">>>")), len(block))
            out += [_prose(line.strip()) for line in block[:cut]]
            if cut < len(block):
                indent = len(block[cut]) - len(block[cut].lstrip())
                out += ["", *(line[indent:] for line in block[cut:])]
        out.append("")
    return out


def process(app, what, name, obj, options, lines):
    """Sphinx: called with each docstring that autodoc shows; numpydoc sections go through napoleon."""
    start = next((n - 1 for n, line in enumerate(lines) if n and SECTION.fullmatch(line)), len(lines))
    rest = LEFT_OUT.sub("", "\n".join(lines[start:])).splitlines()
    if rest:
        from sphinx.ext.napoleon import Config, NumpyDocstring

        rest = [re.sub(r"(?<!`)`([^`]+)`(?!`)", r"``\1``", line) for line in rest]
        config = Config(napoleon_use_param=False, napoleon_use_rtype=False, napoleon_use_ivar=True)
        rest = str(NumpyDocstring(rest, config, app, "function", name, obj, options)).splitlines()
    lines[:] = restructured(lines[:start]) + rest


def skip(app, what, name, obj, skipped, options):
    """Sphinx: leave out the fields of named tuples, which have no docstring of their own."""
    return True if type(obj).__name__ == "_tuplegetter" else None


def setup(app):
    """Sphinx: pass docstrings through `process`."""
    app.connect("autodoc-skip-member", skip)
    app.connect("autodoc-process-docstring", process)
    return {"parallel_read_safe": True}
