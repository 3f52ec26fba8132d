"""A page for each law and the section of the unloading rules, built from their records."""

import contextlib
import inspect
import math
import re
import warnings
from pathlib import Path

import numpy as np

import demlaws as dl
from demlaws.core.unloading import GIVEN, RULES
from demlaws.laws import definition as laws_definition
from demlaws.laws.registry import registry
from demlaws.make import example_curve, example_law
from making.equations import EQUATIONS
from making.links import relinked
from making.symbols import COMMON, OF_LAW, meaning
from making.words import GROUPS, WORDS

ROOT = Path(__file__).resolve().parents[2]
GRANITE = dl.Contact.between(dl.materials.granite, dl.materials.granite, radius1=8.7e-3, radius2=8.7e-3)
SHOWN = "[two granite spheres](../../theory/contact.md#two-granite-spheres)"
LOADS = np.geomspace(1e-2, 1e3, 241)
NOTES = "docs/theory/notes/{}.md"
"""What is to be said of one law only, written by hand; part of its page."""


def number(value):
    """Three digits, or "any" for infinity."""
    return "any" if not math.isfinite(value) else f"{value:.3g}"


def quietly(function, *arguments, **options):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", dl.ValidityWarning)
        return function(*arguments, **options)


def equation(name):
    """Formula blocks of a law's equation."""
    return "".join(f"```{{math}}\n{line}\n```\n\n" for line in EQUATIONS[name].lines)


def table(head, rows):
    """A table in Markdown; bars in cells are kept from ending them."""
    body = [[str(cell).replace("|", "\\|").replace("\n", " ") for cell in row] for row in rows]
    return "\n".join("| " + " | ".join(row) + " |" for row in [head, ["---"] * len(head), *body]) + "\n"


def prose(text):
    """A docstring as Markdown: indented lines as they stand, the rest as running text with its stars kept."""
    out = []
    for part in inspect.cleandoc(text or "").split("\n\n"):
        if part.startswith("    ") or ">>>" in part:
            out.append(f"```text\n{inspect.cleandoc(part)}\n```")
        else:
            pieces = part.split("`")
            escaped = (p if i % 2 else p.replace("*", "\\*").replace("_", "\\_") for i, p in enumerate(pieces))
            out.append(re.sub(r"\\\*\\\*(\w[^*]*?)\\\*\\\*", r"**\1**", "`".join(escaped)))
    return "\n\n".join(out)


def differs(law, force):
    """Whether a law differs visibly from Hertz's in a picture to this force."""
    smooth = quietly(example_law("hertz", law.contact).overlap, force)
    return abs(quietly(law.overlap, force) / smooth - 1.0) > 0.02


def draw_law(law, top, folder):
    """Force against overlap to `top` [N] with unloading, linear; stiffness over the loads, logarithmic; Hertz in grey."""
    from demlaws import plots

    fig, (left, right) = plots.figure(columns=2, width=4.6, height=3.6)
    colour = plots.colour(law.name) if law.name != "hertz" else "tab:blue"
    for curve, shade in ((example_law("hertz", law.contact), "0.6"), (law, colour)):
        style = (
            {"color": shade} if shade != "0.6" else {"color": shade, "ls": ":", "lw": 2.5, "zorder": 3}
        )  # seen on equal curves
        if shade != "0.6" or law.name != "hertz":
            path = quietly(dl.driver.force_controlled, curve, [top, 0.0])
            peak = int(np.argmax(path.force))
            path[: peak + 1].plot(left, label=curve.name, **style)
            if shade != "0.6":
                path[peak:].plot(left, color=shade, ls="--", label=f"unloading, {law.unloading}")
        overlap = np.asarray(quietly(curve.overlap, LOADS))
        stiffness = np.asarray(quietly(curve.stiffness, overlap))
        shown = (overlap > 0) & (stiffness > 0)
        right.loglog(LOADS[shown], stiffness[shown] / 1e3, **style)
    left.set(xlim=(0, None), ylim=(0, None), xlabel="overlap δ (µm)", ylabel="force P (N)")
    right.set(xlabel="force P (N)", ylabel="stiffness K (N/mm)")
    left.legend(frameon=False, fontsize=8)
    name = f"{law.name}.svg"
    plots.save(fig, folder / name)
    return name


def rules():
    """Name → (rule, name of a law that takes it): the general rules on a yielding rough contact, a law's own on that law."""
    found = {name: (rule, "rough-plastic") for name, rule in RULES.items()}
    for name, definition in registry().items():
        for rule in definition.rules.own:
            found.setdefault(rule.name, (rule, name))
    return found


def cautions(definition, law):
    """Sentences with the limits of a law."""
    sentences = []
    if definition.advice.smooth:
        sentences.append("It neglects roughness: a rough contact is far softer at low load.")
    if definition.needs_map:
        sentences.append("It needs a measured height map; with a roughness alone, use another law.")
    if definition.loading.computed == laws_definition.ROOT:
        sentences.append("Its force is the root of an equation, solved at each call: for many contacts use its table.")
    if definition.needs_map:
        sentences.append(
            "Its curve is a numerical solution, stored as a table: the first use for a new contact takes some seconds."
        )
    elif definition.solved:
        sentences.append("Its curve is data of the package, within 1e-5 of a numerical solution.")
    if not definition.collapses:
        sentences.append("An engine needs a table for each radius.")
    for limit in quietly(definition.limits, law.contact, **law.options):
        low, high = limit.minimum_force, limit.maximum_force
        side = f"below {number(low)} N" if low > 0 else f"above {number(high)} N"
        if low > 0 and math.isfinite(high):
            side = f"outside {number(low)} to {number(high)} N"
        sentences.append(f"For this contact {side}: {limit.reason}.")
    return sentences


def rule_link(rule):
    """Link from the page of a law to a rule."""
    return f"[{rule}](../../theory/contact.md#{rule})"


def rules_of(name, law):
    """Links to the rules that a law takes; the others would create energy with it."""
    accepted = []
    for rule in {**RULES, **registry()[name].offered()}:
        try:
            curve = quietly(example_curve, name, law.contact, **law.options).joined("elastic") if rule == GIVEN else rule
            quietly(law.joined, curve)
            accepted.append(rule_link(rule))
        except dl.DemlawsError:
            continue
    return accepted


def worked_example(name, law):
    """A listing for this law on the contact of its picture, and overlap and stiffness at a load."""
    reach = quietly(law.overlap, 10.0)
    stiffness = quietly(law.stiffness, reach)
    result = f"At 10 N: overlap {reach * 1e6:.4g} µm, stiffness {stiffness / 1e3:.4g} N/mm ({SHOWN})."
    return f"```python\nlaw = dl.law({call(name, law)})\n```\n\n{result}\n"


def law_page(name, definition, folder):
    """The page of one law, its picture written beside it."""
    module = inspect.getmodule(definition.prepare)
    law = quietly(example_law, name, GRANITE)
    shown, usual = law, definition.default_rule(**law.options)
    with contextlib.suppress(dl.DemlawsError):  # elastic unloading would not be seen
        shown = quietly(example_law, name, GRANITE, "hertz" if usual == "elastic" else usual)
    top = 50.0 if name == "hertz" or differs(shown, 50.0) else 1000.0
    picture = draw_law(shown, top, folder)
    words = WORDS[name]
    text = [
        f"# {name}\n",
        f"{words.physics}\n\n**Use it for** {words.use}.\n",
        f"![Force and stiffness of {name}]({picture})\n",
        f"*Loading to {top:g} N and unloading; tangent stiffness of first loading ({SHOWN}).*\n",
        "## Equation\n",
        equation(name),
    ]
    known = [(s, meaning(name, s)) for s in EQUATIONS[name].symbols.split() if s not in COMMON - {*OF_LAW.get(name, ())}]
    rows = [(f"`{s}`", *reversed(match)) for s, match in known if match]
    text.append("P, K, δ, R, E\\*, σ, Df, H_m: [terms](../../theory/contact.md#terms).\n")
    if rows:
        text.append(table(["symbol", "unit", "meaning"], rows))
    needed = ", ".join(f"`{n}`" for n in ("radius", "modulus", *definition.needed(**law.options)))
    text.append(f"## Example\n\nRequired quantities of the contact: {needed}.\n")
    text.append(worked_example(name, law))
    if definition.options:
        text.append("Options, in Python and by `--option NAME=VALUE`:\n")
        text.append("\n".join(f"- {prose(line)}" for line in definition.option_lines()) + "\n")
    text.append("## Limits\n\n" + "\n".join(f"- {prose(s)}" for s in cautions(definition, law) or ["None known."]) + "\n")
    accepted = ", ".join(rules_of(name, law))
    text.append(f"## Unloading\n\nDefault: `{definition.default_rule(**law.options)}`. Accepted: {accepted}.\n")
    text.append(f"## Source\n\n{prose(definition.source)}. ([Bibliography](../../bibliography.md))\n")
    _, _, more = module.__doc__.partition("\n\n")  # the first line is the source
    text.append(f"{prose(more)}\n")
    notes = ROOT / NOTES.format(name)
    if notes.exists():
        text.append(f"## Notes\n\n{relinked(notes.read_text(), NOTES.format(name), f'made/theory/{name}.md')}")
    return "\n".join(text)


def call(name, law):
    """The words of dl.law for this law with its example's options."""
    shown = [f'"{name}"', "contact"]
    for option, value in law.options.items():
        plain = isinstance(value, (int, float, str))
        text = f"{value:g}".replace("e+0", "e") if isinstance(value, float) else repr(value)
        shown.append(f"{option}={text}" if plain else f"{option}=...")
    return ", ".join(shown)


def rule_section(rule, shown_by):
    """The section of one unloading rule."""
    only = f"Only for laws that define it, such as `{shown_by}`." if rule.curve == "law" else ""
    spelled = 'Write `unloading=dl.law("hertz", contact)` or another curve.' if rule.name == GIVEN else ""
    return f"### {rule.name}\n\n{prose(type(rule.tag).__doc__)}\n\n{only}{spelled}\n"


def rule_sections():
    """The unloading rules, a section each."""
    return "\n".join(rule_section(rule, shown_by) for rule, shown_by in rules().values())


def write(folder):
    """Write the pages of all laws into `folder`; returns group → names of its pages."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, definition in registry().items():
        (folder / f"{name}.md").write_text(law_page(name, definition, folder))
    return GROUPS
