"""A page for each law and each rule, from its record: a new law or rule has its page by existing."""

import ast
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
from making.symbols import meaning

ROOT = Path(__file__).resolve().parents[2]
GRANITE = dl.Contact(radius=4.35e-3, modulus=32.32e9, roughness=2.40e-6, fractal_dimension=2.22, hardness=6.266e9)
SHOWN = "R = 4.35 mm, E\\* = 32.32 GPa, σ = 2.40 µm, Df = 2.22, H_m = 6.266 GPa (granite test SS(12–18))"
LOADS = np.geomspace(1e-2, 1e3, 241)
UNITS = {"roughness": "m", "fractal_dimension": "", "hardness": "Pa"}


def number(value):
    """Three figures and words for no bound."""
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
    """(name, what its comment says) of the fields of the NamedTuples in a law's file whose names end with `suffix`."""
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
    if definition.exact is None:
        return None
    overlap = np.geomspace(law.overlap(LOADS[0]), law.overlap(LOADS[-1]), 400)
    for kink in law.kinks():
        overlap = overlap[np.abs(overlap / kink - 1.0) > 1e-6]
    force, stiffness = definition.exact(law.contact, overlap, **law.options)
    given = quietly(law.force, overlap), quietly(law.stiffness, overlap)
    worst = [
        float(np.max(np.abs(np.asarray(g, np.longdouble) / e - 1))) for g, e in zip(given, (force, stiffness), strict=True)
    ]
    return [value / np.finfo(float).eps for value in worst]


def kept_costs():
    """(machine, date, {(law, rule, evaluation): ratio to a copy}) of tests/benchmarks/ratios.json, the newest machine there."""
    kept = json.loads((ROOT / "tests" / "benchmarks" / "ratios.json").read_text())
    machine, record = max(kept.items(), key=lambda item: item[1]["measured"])
    costs = {}
    for key, (ratio, *_) in record["ratios"].items():
        kind, _, rest = key.partition(": ")
        words = [word.strip() for word in rest.split(",")]
        if kind == "kernels" and words[-1] == "mixture":
            costs[tuple(words[:4])] = ratio
    return machine, record["measured"], costs


def draw_law(law, folder):
    """Force, and the exponent of the stiffness d ln K/d ln P, over the loads; Hertz beside it."""
    from demlaws import plots

    fig, (left, right) = plots.figure(columns=2, width=5.0, height=3.6)
    hertz = example("hertz", law.contact)
    for one, colour, label in (
        (hertz, "0.6", "Hertz"),
        (law, plots.colour(law.name), law.definition.drawing.label or law.name),
    ):
        overlap = np.asarray(quietly(one.overlap, LOADS))
        stiffness = np.asarray(quietly(one.stiffness, overlap))
        shown = (overlap > 0) & (stiffness > 0)  # below a seating load there is no curve
        overlap, stiffness, loads = overlap[shown], stiffness[shown], LOADS[shown]
        left.loglog(overlap * 1e6, loads, color=colour, label=label)
        right.semilogx(loads, np.gradient(np.log(stiffness), np.log(loads)), color=colour, label=label)
    left.set(xlabel="overlap δ [µm]", ylabel="force P [N]")
    right.set(xlabel="force P [N]", ylabel="exponent of the stiffness d ln K / d ln P", ylim=(-0.05, 1.05))
    left.legend(frameon=False)
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
    """Sentences: when the law is not the one to take."""
    said = []
    if definition.advice.smooth:
        said.append("It leaves roughness out: a rough contact at low load is far softer.")
    if definition.needs:
        said.append(f"It cannot be made without the contact's {', '.join(f'`{n}`' for n in definition.needs)}.")
    if definition.needs_map:
        said.append("It needs a measured height map; from a roughness alone take another law.")
    if definition.implicit:
        said.append("Its force is the root of an equation, found anew at each call: for many contacts take its table.")
    if definition.solved:
        said.append(
            "Its curve comes from a solver and is a table from the start: the first use at a new contact costs seconds."
        )
    if not definition.collapses:
        said.append("One dimensionless curve does not serve all contacts: an engine needs a table for each radius.")
    if definition.seated(**law.options):
        said.append("It starts at a declared seating load: absolute overlaps depend on that, differences between loads do not.")
    for limit in quietly(definition.limits, law.contact, **law.options):
        low, high = limit.minimum_force, limit.maximum_force
        side = f"below {number(low)} N" if low > 0 else f"above {number(high)} N"
        if low > 0 and math.isfinite(high):
            side = f"outside {number(low)} to {number(high)} N"
        said.append(f"For this contact {side}: {limit.reason}.")
    return said


def rules_of(name, law):
    """(rule, "yes" or why not) for each rule that any law may take, and for the law's own."""
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


def law_page(name, definition, folder, costs):
    """The page of one law, its picture written beside it."""
    module = inspect.getmodule(definition.prepare)
    law = quietly(example, name, GRANITE)
    picture = draw_law(law, folder)
    text = [
        f"# {name}\n",
        f"{definition.description[:1].upper()}{definition.description[1:]}.\n",
        equation(definition.equation),
    ]
    known = [(s, meaning(name, s)) for s in symbols_of(definition.equation)]
    rows = [(f"`{s}`", *reversed(found)) for s, found in known if found]
    if rows:
        text.append(table(["symbol", "unit", "meaning"], rows))
    fields = fields_of(module, "Shape") + fields_of(module, "Params")
    if fields:
        text.append("What the compiled law keeps of a contact:\n")
        text.append(table(["name", "meaning"], [(f"`{field}`", prose(comment)) for field, comment in fields]))
    text.append(f"**Source.** {prose(definition.source)}.\n\n{prose(module.__doc__)}\n")
    needed = ", ".join(f"`{n}`" for n in ("radius", "modulus", *definition.needed(**law.options)))
    text.append(f"**Needs** of the contact: {needed}.\n")
    if definition.options:
        text.append("**Options** of `dl.law(name, contact, ...)` and of `--option NAME=VALUE`:\n")
        text.append("\n".join(f"- {prose(line)}" for line in definition.option_lines()) + "\n")
    text.append(f"```python\nlaw = dl.law({call(name, law)})\n```\n")
    text.append(f"## Curve\n\n![Force and stiffness exponent of {name}]({picture})\n")
    text.append(f"*{SHOWN}; a pure power law P ∝ δ^m has the exponent (m - 1)/m, Hertz's 1/3.*\n")
    text.append(
        "## When not to use it\n\n" + "\n".join(f"- {prose(s)}" for s in cautions(definition, law) or ["Nothing known."]) + "\n"
    )
    text.append(f"## Unloading\n\nWhere none is named: `{definition.default_unloading}`.\n")
    text.append(table(["rule", "taken"], rules_of(name, law)))
    text.append("## Error and cost\n")
    worst = rounding(definition, law)
    if worst is None:
        text.append("The record names no closed form in extended precision; `make trade` and `make stability` measure it.\n")
    else:
        text.append(
            f"Against the equation in extended precision, {number(LOADS[0])} to {number(LOADS[-1])} N, this contact, computed "
            f"when the page was built: force within {worst[0]:.1f} ε, stiffness within {worst[1]:.1f} ε (ε = 2.2e-16).\n"
        )
    machine, date, all_costs = costs
    rows = [(*key[1:], f"{ratio:.2f}") for key, ratio in sorted(all_costs.items()) if key[0] == name]
    if rows:
        text.append(f"Time of a batch over a copy of the same arrays, kept by `make bench KEEP=1` on {date} ({machine}):\n")
        text.append(table(["unloading", "evaluation", "contact values", "× copy"], rows))
    else:
        text.append("No cost of it is kept in tests/benchmarks/ratios.json; `make trade` measures it.\n")
    return "\n".join(text)


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
    state = ", ".join(f"`{name}`" for name in rule.state) or "nothing: no state"
    curves = {"own": "its own curve of first loading", "hertz": "a Hertz curve", "given": "a curve that you give"}
    curves["law"] = f"a curve of the law's own parameters; only laws that bring the rule take it, such as `{shown_by}`"
    spelled = f'unloading="{rule.name}"' if rule.curve != "given" else 'unloading=dl.law("hertz", contact)'
    number_text = "none: C++ does not have it" if rule.number is None else f"{rule.number}"
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
                    ("a contact remembers", state),
                    ("number in demlaws_table.h", number_text),
                ],
            ),
            f"```python\nlaw = dl.law({call(shown_by, law)}, {spelled})\n```\n",
            f"![Force against overlap, rule {rule.name}]({picture})\n",
            f"*{shown_by}, loaded to 50 N, released, loaded to 100 N, released; {SHOWN}.*\n",
            "A law whose stiffness anywhere exceeds that of the unloading curve is refused a rule: it would return more "
            "work than it took. A contact whose bodies part is virgin again.\n",
        ]
    )


def write(folder):
    """Write all pages into `folder`; returns (names of law pages, names of rule pages)."""
    folder.mkdir(parents=True, exist_ok=True)
    costs = kept_costs()
    for name, definition in registry().items():
        (folder / f"{name}.md").write_text(law_page(name, definition, folder, costs))
    for rule, shown_by in rules().values():
        (folder / f"rule-{rule.name}.md").write_text(rule_page(rule, shown_by, folder))
    return list(registry()), [f"rule-{name}" for name in rules()]
