"""The equations of the records, plain text, as LaTeX; and LaTeX as MathML, which browsers show without a script."""

import re

_LETTERS = "αβγδεζηθκλμνξπρστφχψωΓΔΘΛΣΦΨΩ"
_NAMES = (
    r"alpha beta gamma delta varepsilon zeta eta theta kappa lambda mu nu xi pi rho sigma tau varphi chi psi omega "
    r"Gamma Delta Theta Lambda Sigma Phi Psi Omega"
)
GREEK = {letter: name for letter, name in zip(_LETTERS, re.split(" ", _NAMES), strict=True)}
POWERS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")
FUNCTIONS = {
    "arcsin",
    "arctan",
    "cos",
    "erf",
    "erfc",
    "exp",
    "ln",
    "log",
    "max",
    "min",
    "sin",
    "tan",
    "sqrt",
    "cosh",
    "sinh",
    "tanh",
}
SIGNS = {
    "·": r"\cdot ",
    "×": r"\times ",
    "≤": r"\le ",
    "≥": r"\ge ",
    "∫": r"\int ",
    "½": r"\tfrac{1}{2}",
    "∝": r"\propto ",
    "−": "-",
}
SIGNS |= {
    "±": r"\pm ",
    "≈": r"\approx ",
    "∞": r"\infty ",
    "→": r"\to ",
    "∂": r"\partial ",
    "≪": r"\ll ",
    "≫": r"\gg ",
    "∇": r"\nabla ",
}

TOKEN = re.compile(
    r"(?P<power>\^(?:-?\d+(?:[./]\d+)?|\w+|(?=\()))"
    r"|(?P<raised>[⁰¹²³⁴⁵⁶⁷⁸⁹⁻]+)"
    r"|(?P<subscript>_(?:\d+/\d+|\w+))"
    r"|(?P<prime>['′]+)"
    r"|(?P<star>(?<=[A-Za-zα-ωΑ-Ω'′])\*(?![A-Za-z0-9(]))"
    r"|(?P<inverse>⁻¹)"
    r"|(?P<number>\d+(?:\.\d+)?(?:e-?\d+)?)"
    r"|(?P<differential>d(?=[PKδ](?![a-z])))"
    r"|(?P<indexed>[PδFKa](?:max|min)\b|[δk][a-z](?![a-z]))"
    r"|(?P<word>[A-Za-z]{2,}(?:-[A-Za-z]+)*(?:'s\b)?|\ba(?= [a-z]{2}))"
    r"|(?P<letter>[A-Za-zα-ωΑ-Ω]\u0302?)"
    r"|(?P<other>.)"
)
SHORT = re.compile(r"^(?:D[fF]|[A-Z][a-z]?)$")
"""Two letters that are one symbol, as in Df."""


def _braced(text, start):
    """End of the bracket that opens at `start`."""
    depth = 0
    for place in range(start, len(text)):
        depth += (text[place] == "(") - (text[place] == ")")
        if depth == 0:
            return place
    return len(text) - 1


def _subscript(text):
    return f"_{{{text}}}" if len(text) == 1 or not text.isalpha() else rf"_{{\mathrm{{{text}}}}}"


def latex(equation):
    """LaTeX of an equation as the records have it: "K = π R p_y δ^1.5" gives K = \\pi R p_{y} \\delta ^{1.5}.

    Letters followed by a figure get it as an index (A0), words become text, brackets after ^ and √ an exponent and a root.
    """
    out, place, words = [], 0, []

    def flush():
        if words:
            out.append(rf"\ \text{{{' '.join(words)}}}\ ")
            words.clear()

    while place < len(equation):
        match = TOKEN.match(equation, place)
        kind, text = match.lastgroup, match.group()
        following = equation[match.end() :]
        place = match.end()
        if kind == "word" and text not in FUNCTIONS and not SHORT.match(text) and following[:1] != "_":
            words.append(text)
            continue
        if kind == "other" and text == " ":
            if not words:
                out.append(" ")
            continue
        flush()
        if kind == "power":
            if text == "^":
                end = _braced(equation, place)
                out.append(f"^{{{latex(equation[place + 1 : end])}}}")
                place = end + 1
            else:
                out.append(f"^{{{text[1:]}}}")
        elif kind in ("raised", "inverse"):
            out.append(f"^{{{text.translate(POWERS)}}}")
        elif kind == "subscript":
            out.append(_subscript(text[1:]))
        elif kind == "prime":
            out.append("'" * len(text))
        elif kind == "star":
            raised = re.match(r"[⁰¹²³⁴⁵⁶⁷⁸⁹⁻]+|\^\d+(?:\.\d+)?", following)  # E*² has one exponent in LaTeX
            more = "" if not raised else " " + raised.group().lstrip("^").translate(POWERS)
            out.append(rf"^{{*{more}}}")
            place += raised.end() if raised else 0
        elif kind == "word":
            if text in FUNCTIONS:
                out.append(rf"\operatorname{{{text}}}")
            elif SHORT.match(text):
                out.append(f"{text[0]}_{{{text[1:]}}}")
            else:
                out.append(rf"\mathrm{{{text}}}")
        elif kind == "differential":
            out.append(r"\mathrm{d}")
        elif kind == "indexed":
            out.append(("\\" + GREEK[text[0]] if text[0] in GREEK else text[0]) + _subscript(text[1:]))
        elif kind == "letter":
            plain = "\\" + GREEK[text[0]] + " " if text[0] in GREEK else text[0]
            out.append(plain if len(text) == 1 else rf"\hat{{{plain.strip()}}}")
            index = re.match(r"\d+", following)
            if index:
                out.append(_subscript(index.group()))
                place += index.end()
        elif text == "√":
            if equation[place : place + 1] == "(":
                end = _braced(equation, place)
                inner = equation[place + 1 : end]
                place = end + 1
            else:
                inner = re.match(r"[A-Za-zα-ω][\d_\w]?\*?|\d+|", following).group() or following[:1]
                place += len(inner)
            out.append(rf"\sqrt{{{latex(inner)}}}")
        elif text in SIGNS:
            out.append(SIGNS[text])
        elif text in GREEK:
            out.append("\\" + GREEK[text] + " ")
        elif text in "%&#${}\\":
            out.append("\\" + text)
        else:
            out.append(text)
    flush()
    return re.sub(r"^(?:\\ )+|(?:\\ )+$", "", "".join(out).strip() + " ").strip()


def symbols_of(equation):
    """The symbols of an equation in the order in which they come; words, functions and π are none."""
    found, place = [], 0
    while place < len(equation):
        match = TOKEN.match(equation, place)
        kind, text = match.lastgroup, match.group()
        place = match.end()
        named = kind in ("letter", "indexed") or (kind == "word" and (SHORT.match(text) or equation[place : place + 1] == "_"))
        if not named or text in "πΣ" or text in FUNCTIONS:
            continue
        more = re.match(r"(?:\d+)?(?:_(?:\d+/\d+|\w+))?['′]*(?:\*(?![A-Za-z0-9(]))?['′]*", equation[place:])
        place += more.end()
        name = text + more.group().replace("′", "'")
        if name not in found:
            found.append(name)
    return found


def lines(equation):
    """An equation's parts, one a line: cut at commas outside brackets; mere words stay with what they follow."""
    parts, depth, start = [], 0, 0
    for place, sign in enumerate(equation):
        depth += (sign in "([") - (sign in ")]")
        if depth == 0 and sign in ",;" and equation[place + 1 : place + 2] == " ":
            parts.append(equation[start:place].strip())
            start = place + 1
    parts.append(equation[start:].strip())
    together = parts[:1]
    for part in parts[1:]:
        if re.search(r"[=∝]", part):
            together.append(part)
        else:
            together[-1] += f", {part}"
    return together


def mathml(formula, display="block"):
    """MathML of LaTeX; a formula that cannot be read is a ValueError that shows it."""
    from latex2mathml.converter import convert

    try:
        return convert(formula, display=display)
    except Exception as error:
        raise ValueError(f"formula {formula!r}: {type(error).__name__}: {error}") from error


def setup(app):
    """Sphinx: formulae as MathML."""

    def visit(display):
        def render(self, node):
            shown = mathml(node.astext(), display)
            self.body.append(f'<div class="math">{shown}</div>' if display == "block" else shown)
            from docutils import nodes

            raise nodes.SkipNode

        return render

    app.add_html_math_renderer("mathml", (visit("inline"), None), (visit("block"), None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
