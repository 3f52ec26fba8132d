"""A page for each law and each rule, built from its record."""

import ast
import contextlib
import inspect
import json
import math
import warnings
from pathlib import Path

import numpy as np

import demlaws as dl
from demlaws.core.unloading import GIVEN, RULES
from demlaws.errors import NotPassive
from demlaws.laws.registry import registry
from demlaws.make import example, example_curve
from making.formula import latex, lines, symbols_of
from making.symbols import SYMBOLS, meaning
from making.words import WORDS
from studies.extremes.exact import EXACT

ROOT = Path(__file__).resolve().parents[2]
GRANITE = dl.Contact(radius=4.35e-3, modulus=32.32e9, roughness=2.40e-6, fractal_dimension=2.22, hardness=6.266e9)
SHOWN = "R = 4.35 mm, E\\* = 32.32 GPa, σ = 2.40 µm, Df = 2.22, H_m = 6.266 GPa (granite test SS(18–18))"
LOADS = np.geomspace(1e-2, 1e3, 241)
UNITS = {"roughness": "m", "fractal_dimension": "", "hardness": "Pa"}


def number(value):
    """Three digits, or "any" for infinity."""
    return "any" if not math.isfinite(value) else f"{value:.3g}"


def quietly(function, *arguments, **options):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", dl.ValidityWarning)
        return function(*arguments, **options)


def equation(text):
    """Formula blocks of a record's equation."""
    return "".join(f"```{{math}}\n{latex(part)}\n```\n\n" for part in lines(text))


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
            out.append("`".join(p if i % 2 else p.replace("*", "\\*").replace("_", "\\_") for i, p in enumerate(pieces)))
    return "\n\n".join(out)


def fields_of(module, suffix):
    """(name, comment) of the fields of the NamedTuples in a law's file whose names end with `suffix`."""
    source = inspect.getsource(module)
    cut = source.splitlines()
    found = []
    for node in ast.parse(source).body:
        if isinstance(node, ast.ClassDef) and node.name.endswith(suffix):
            for field in node.body:
                if isinstance(field, ast.AnnAssign):
                    comment = cut[field.end_lineno - 1].partition("#")[2].strip()
                    if comment:
                        found.append((field.target.id, comment))
    return found


def rounding(definition, law):
    """Largest error of force and stiffness against extended precision, in units of ε, over the loads shown; or None."""
    if definition.name not in EXACT:
        return None
    overlap = np.geomspace(*(quietly(law.overlap, load) for load in (LOADS[0], LOADS[-1])), 400)
    for kink in law.kinks():
        overlap = overlap[np.abs(overlap / kink - 1.0) > 1e-6]
    force, stiffness = EXACT[definition.name](law.contact, overlap, **law.options)
    given = quietly(law.force, overlap), quietly(law.stiffness, overlap)
    worst = [
        float(np.max(np.abs(np.asarray(g, np.longdouble) / e - 1))) for g, e in zip(given, (force, stiffness), strict=True)
    ]
    return [value / np.finfo(float).eps for value in worst]


def kept_costs():
    """(machine, date, {(law, rule, evaluation): ratio to a copy}) of tools/benchmarks/ratios.json, the newest machine there."""
    kept = json.loads((ROOT / "tools" / "benchmarks" / "ratios.json").read_text())
    machine, record = max(kept.items(), key=lambda item: item[1]["measured"])
    costs = {}
    for key, (ratio, *_) in record["ratios"].items():
        kind, _, rest = key.partition(": ")
        words = [word.strip() for word in rest.split(",")]
        if kind == "kernels" and words[-1] == "mixture":
            costs[tuple(words[:4])] = ratio
    return machine, record["measured"], costs


def draw_law(law, folder):
    """Force against overlap to 50 N with unloading, linear, and the stiffness over the loads, logarithmic; Hertz in grey."""
    from demlaws import plots

    fig, (left, right) = plots.figure(columns=2, width=4.6, height=3.6)
    colour = plots.colour(law.name) if law.name != "hertz" else "tab:blue"
    for curve, shade in ((example("hertz", law.contact), "0.6"), (law, colour)):
        label = "Hertz" if curve.name == "hertz" else law.definition.drawing.label or law.name
        if shade != "0.6" or law.name != "hertz":
            path = quietly(dl.driver.force_controlled, curve, [50.0, 0.0])
            peak = int(np.argmax(path.force))
            path[: peak + 1].plot(left, color=shade, label=label)
            if shade != "0.6":
                path[peak:].plot(left, color=shade, ls="--", label=f"unloading, {law.unloading}")
        overlap = np.asarray(quietly(curve.overlap, LOADS))
        stiffness = np.asarray(quietly(curve.stiffness, overlap))
        shown = (overlap > 0) & (stiffness > 0)
        right.loglog(LOADS[shown], stiffness[shown] / 1e3, color=shade)
    left.set(xlim=(0, None), ylim=(0, None), xlabel="overlap δ [µm]", ylabel="force P [N]")
    right.set(xlabel="force P [N]", ylabel="stiffness K [N/mm]")
    left.legend(frameon=False, fontsize=8)
    name = f"{law.name}.svg"
    plots.save(fig, folder / name)
    return name


def rules():
    """Name → (rule, name of a law that shows it): the general rules on a yielding rough contact, a law's own on that law."""
    found = {name: (rule, "rough-plastic") for name, rule in RULES.items()}
    for name, definition in registry().items():
        for rule in definition.rules:
            found.setdefault(rule.name, (rule, name))
    return found


def draw_rule(name, shown_by, folder):
    """Two cycles to 50 and 100 N of a contact under the rule, and under "elastic" where the law takes it."""
    from demlaws import plots

    fig, left = plots.figure(width=6.0, height=3.6)
    for rule, colour in (("elastic", "0.6"), (name, "#d62728")):
        if rule == "elastic" != name and "elastic" not in registry()[shown_by].offered():
            continue
        law = quietly(example, shown_by, GRANITE, rule)
        path = quietly(dl.driver.force_controlled, law, [50.0, 0.0, 100.0, 0.0])
        left.plot(np.asarray(path.overlap) * 1e6, path.force, color=colour, label=rule)
        if name == "elastic":
            break
    left.set(xlabel="overlap δ [µm]", ylabel="force P [N]")
    left.legend(frameon=False)
    picture = f"rule-{name}.svg"
    plots.save(fig, folder / picture)
    return picture


def cautions(definition, law):
    """Sentences with the limits of a law."""
    sentences = []
    if definition.advice.smooth:
        sentences.append("It neglects roughness: a rough contact is far softer at low load.")
    if definition.needs:
        sentences.append(f"It needs the contact's {', '.join(f'`{n}`' for n in definition.needs)}.")
    if definition.needs_map:
        sentences.append("It needs a measured height map; with a roughness alone, use another law.")
    if definition.implicit and not definition.needs_map and not definition.solved:
        sentences.append("Its force is the root of an equation, solved at each call: for many contacts use its table.")
    if definition.needs_map:
        sentences.append(
            "Its curve is a numerical solution, stored as a table: the first use for a new contact takes some seconds."
        )
    elif definition.solved:
        sentences.append("Its curve is data of the package, within 1e-5 of a numerical solution.")
    if not definition.collapses:
        sentences.append("One dimensionless curve does not serve all contacts: an engine needs a table for each radius.")
    for limit in quietly(definition.limits, law.contact, **law.options):
        low, high = limit.minimum_force, limit.maximum_force
        side = f"below {number(low)} N" if low > 0 else f"above {number(high)} N"
        if low > 0 and math.isfinite(high):
            side = f"outside {number(low)} to {number(high)} N"
        sentences.append(f"For this contact {side}: {limit.reason}.")
    return sentences


def rules_of(name, law):
    """(rule, "yes" or the reason against it) for each general rule and for the rules of this law only."""
    out = []
    for rule in {**RULES, **registry()[name].offered()}:
        try:
            curve = quietly(example_curve, name, law.contact, **law.options).joined("elastic") if rule == GIVEN else rule
            quietly(law.joined, curve)
            out.append((f"[{rule}](rule-{rule}.md)", "yes"))
        except NotPassive as refused:
            out.append((f"[{rule}](rule-{rule}.md)", f"refused: {prose(str(refused))}"))
        except dl.DemlawsError as refused:
            out.append((f"[{rule}](rule-{rule}.md)", f"no: {prose(str(refused))}"))
    return out


def worked_example(name, law):
    """A listing for this law, and its output."""
    reach = quietly(law.overlap, 10.0)
    fields = "radius=4.35e-3, modulus=32.32e9, roughness=2.4e-6, fractal_dimension=2.22, hardness=6.266e9"
    printed = "{law.overlap(10.0) * 1e6:.4g} µm, {law.stiffness(law.overlap(10.0)) / 1e3:.4g} N/mm"
    code = f'contact = dl.Contact(\n    {fields}\n)\nlaw = dl.law({call(name, law)})\nprint(f"{printed}")'
    stiffness = quietly(law.stiffness, reach)
    return f"```python\n{code}\n```\n\n```text\n{reach * 1e6:.4g} µm, {stiffness / 1e3:.4g} N/mm\n```\n"


def law_page(name, definition, folder):
    """The page of one law, its picture written beside it."""
    module = inspect.getmodule(definition.prepare)
    law = quietly(example, name, GRANITE)
    shown = law  # elastic unloading would not be seen
    with contextlib.suppress(dl.DemlawsError):
        shown = quietly(example, name, GRANITE, "hertz") if law.unloading == "elastic" else law
    picture = draw_law(shown, folder)
    physics, use = WORDS.get(name, (f"{definition.description}.", "see the source"))
    text = [
        f"# {name}\n",
        f"{physics}\n\n**Use it for** {use}.\n",
        f"![Force and stiffness of {name}]({picture})\n",
        f"*Left: loading to 50 N and unloading. Right: tangent stiffness of first loading. {SHOWN}.*\n",
        "## Equation\n",
        equation(definition.equation),
    ]
    known = [(s, meaning(name, s)) for s in symbols_of(definition.equation)]
    rows = [(f"`{s}`", *reversed(match)) for s, match in known if match]
    if rows:
        text.append(table(["symbol", "unit", "meaning"], rows))
    needed = ", ".join(f"`{n}`" for n in ("radius", "modulus", *definition.needed(**law.options)))
    text.append(f"## Example\n\nRequired of the contact: {needed}.\n")
    text.append(worked_example(name, law))
    if definition.options:
        text.append("Options of `dl.law(name, contact, ...)` and of `--option NAME=VALUE`:\n")
        text.append("\n".join(f"- {prose(line)}" for line in definition.option_lines()) + "\n")
    text.append("## Limits\n\n" + "\n".join(f"- {prose(s)}" for s in cautions(definition, law) or ["None known."]) + "\n")
    text.append(f"## Unloading\n\nDefault: `{definition.default_rule(**law.options)}`.\n")
    text.append(table(["rule", "accepted"], rules_of(name, law)))
    text.append(f"## Source\n\n{prose(definition.source)}. References in full: [bibliography](../../bibliography.md).\n")
    text.append(f"{prose(module.__doc__)}\n")
    worst = rounding(definition, law)
    if worst is not None:
        text.append(
            f"Rounding errors against the equation in extended precision, {number(LOADS[0])} to {number(LOADS[-1])} N, this "
            f"contact: force within {worst[0]:.1f} ε, stiffness within {worst[1]:.1f} ε (ε = 2.2e-16). "
        )
    text.append("Costs of all laws: [one table](../costs.md).\n")
    fields = fields_of(module, "Shape") + fields_of(module, "Params")
    if fields:
        text.append("## Parameters of the compiled law\n\nFor maintainers.\n")
        text.append(table(["name", "meaning"], [(f"`{field}`", prose(comment)) for field, comment in fields]))
    return "\n".join(text)


def cost_page():
    """One table with the kept costs of all laws."""
    machine, date, costs = kept_costs()
    rows = [(f"[{law}](theory/{law}.md)", *key, f"{ratio:.2f}") for (law, *key), ratio in sorted(costs.items())]
    return (
        "# Costs of the laws\n\nTime of a batch of contacts, half of them loading and half unloading, over the time of a copy "
        f"of the same arrays; kept by `make bench KEEP=1` on {date} ({machine}).\n\n"
        + table(["law", "unloading", "evaluation", "contact values", "× copy"], rows)
    )


def symbol_table():
    """All symbols with unit and meaning."""
    return table(["symbol", "unit", "meaning"], [(f"`{s}`", unit, meaning) for s, (meaning, unit) in SYMBOLS.items()])


def call(name, law):
    """The words of dl.law for this law with its example's options."""
    shown = [f'"{name}"', "contact"]
    for option, value in law.options.items():
        plain = isinstance(value, (int, float, str))
        shown.append(f"{option}={value!r}" if plain else f"{option}=...")
    return ", ".join(shown)


def rule_page(rule, shown_by, folder):
    """The page of one unloading rule."""
    picture = draw_rule(rule.name, shown_by, folder)
    state = ", ".join(f"`{name}`" for name in rule.state) or "nothing"
    curves = {"own": "its own curve of first loading", "hertz": "a Hertz curve", "given": "a user-supplied curve"}
    curves["law"] = f"a curve of the law's parameters; only for laws that define the rule, such as `{shown_by}`"
    spelled = f'unloading="{rule.name}"' if rule.curve != "given" else 'unloading=dl.law("hertz", contact)'
    number_text = "none (not available in C++)" if rule.number is None else f"{rule.number}"
    law = quietly(example, shown_by, GRANITE, rule.name)
    return "\n".join(
        [
            f"# Unloading: {rule.name}\n",
            f"{rule.description[:1].upper()}{rule.description[1:]}.\n",
            f"{prose(type(rule.tag).__doc__)}\n",
            table(
                ["", ""],
                [
                    ("unloads along", curves.get(rule.curve, rule.curve)),
                    ("state of a contact", state),
                    ("number in demlaws_table.h", number_text),
                ],
            ),
            f"```python\nlaw = dl.law({call(shown_by, law)}, {spelled})\n```\n",
            f"![Force against overlap, rule {rule.name}]({picture})\n",
            f"*{shown_by}, loaded to 50 N, unloaded, loaded to 100 N, unloaded; {SHOWN}.*\n",
            "The rule is refused for a law that is anywhere stiffer than the unloading curve, because the pair would create "
            "energy. The history is lost when the bodies separate.\n",
        ]
    )


def write(folder):
    """Write all pages into `folder`; returns (names of law pages, names of rule pages)."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, definition in registry().items():
        (folder / f"{name}.md").write_text(law_page(name, definition, folder))
    for rule, shown_by in rules().values():
        (folder / f"rule-{rule.name}.md").write_text(rule_page(rule, shown_by, folder))
    return list(registry()), [f"rule-{name}" for name in rules()]
