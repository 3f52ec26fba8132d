"""What ways of computing contacts cost inside the engines, measured there: a close packing that stands still."""

import importlib
import json
import subprocess
import tempfile
from pathlib import Path
from typing import NamedTuple

from demlaws.errors import DemlawsError
from studies.trade.candidates import NAMES, Way


class StepCost(NamedTuple):
    """One way in one engine; times per contact and step, one thread."""

    way: Way
    step: float  # ns of the whole step
    over_hertz: float  # whole step over that with the engine's own Hertz
    law: float  # share of the step that the normal law takes
    model: float  # YADE: share of the Law2 functor, with shear and friction; LIGGGHTS, LAMMPS: share of the pair loop


def available(engine):
    """None where the engine can be started, else the line with the reason."""
    try:
        if engine == "yade":
            from demlaws.yade.run import environment

            environment()
        elif engine == "liggghts":
            from demlaws.liggghts.build import library_path
            from demlaws.liggghts.run import versions

            versions()
            library_path()
        elif engine == "lammps":
            from demlaws.lammps.run import versions as lammps_versions

            lammps_versions()
        else:
            raise DemlawsError(f"engine {engine!r}: choose {', '.join(NAMES)}")
    except DemlawsError as error:
        return str(error)
    return None


def describe(way, folder, contact, number):
    """A way as the scripts under YADE take it; a table is written to `folder`."""
    given = way.law
    if way.rtol:
        given = str(Path(folder) / f"{number}.tbl")
        way.bind(contact).save(given)
    return {**way._asdict(), "options": {} if way.rtol else dict(way.options), "given": given}


def under_yade(script, given, progress=lambda text: None):
    """`answer_of` a script of studies/ (path there) under YADE."""
    from demlaws.yade.run import command, environment

    return answer_of("YADE", command(Path(__file__).parents[1] / script), environment(), given, progress)


def answer_of(engine, line, environment, given, progress):
    """What a program that ends with `under_yade.serve` answers; progress(text): for each of its lines PROGRESS text."""
    with tempfile.TemporaryDirectory() as scratch:
        files = [Path(scratch) / name for name in ("given.json", "found.json")]
        files[0].write_text(json.dumps(given))
        pipes = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
        with subprocess.Popen([*line, *map(str, files)], env=environment, text=True, errors="replace", **pipes) as process:
            noise = ""
            try:
                for text in process.stdout:
                    if text.startswith("PROGRESS "):
                        progress(text.removeprefix("PROGRESS ").strip())
                    else:
                        noise = (noise + text)[-600:]
            except BaseException:
                process.kill()
                raise
        if not files[1].is_file():
            raise DemlawsError(f"{engine} stopped (exit {process.returncode}): {noise.strip()}")
        return json.loads(files[1].read_text())


def yade_costs(ways, given, contact, side=8, repeats=40):
    """`StepCost` of each way in YADE. given: young, poisson, density, surface, radius, overlap; contact: of two grains."""
    with tempfile.TemporaryDirectory() as scratch:
        own = [Way("hertz", model="hertz"), *ways]
        described = [describe(way, scratch, contact, n) for n, way in enumerate(own)]
        found = under_yade(
            "costs/yade_cost.py", {"cdm": (1e9, 0.5), **given, "side": side, "repeats": repeats, "ways": described}
        )
    # other engines' share of a step does not depend on the law, what they measured on it is noise
    rest = min(f["rest"] / f["contacts"] for f in found)
    native = found[0]["loop"] / found[0]["contacts"] + rest
    # a functor of Mindlin's that does nothing: the remaining cost of the loop
    nothing = [f["nothing"] / f["contacts"] for f in found if f["nothing"]]
    bare = min(nothing) if nothing else float("nan")
    costs = []
    for way, f in zip(ways, found[1:], strict=True):
        loop = f["loop"] / f["contacts"]
        if f["mindlin"] is None:
            step = loop + rest
            costs.append(StepCost(way, step, step / native, float("nan"), (loop - bare) / step))
            continue
        # differences within one packing, on the scale of the native one
        added, model = (loop - f["mindlin"] / f["contacts"]), (loop - f["nothing"] / f["contacts"])
        step = native + added
        costs.append(StepCost(way, step, step / native, added / step, model / step))
    return costs


def plugin_costs(engine, ways, given, side=12, rounds=5, steps=200, progress=lambda things: things):
    """`StepCost` of each way in LIGGGHTS or LAMMPS; given as for YADE, with "contact" and, unless of granite, "grains"."""
    measure = importlib.import_module(f"studies.costs.{engine}_cost").measure
    own = [Way("hertz", model="hertz"), *ways]
    described = [{**way._asdict(), "options": dict(way.options)} for way in own]
    found = measure(given, described, side, rounds, steps, progress)
    stock = found[0]["step"]
    costs = []
    for way, f in zip(ways, found[1:], strict=True):
        law = float("nan") if f["alone"] is None else f["alone"] * f["contacts"] / f["step"]
        costs.append(StepCost(way, f["step"] / f["contacts"], f["step"] / stock, law, f["pair"] / f["step"]))
    return costs
