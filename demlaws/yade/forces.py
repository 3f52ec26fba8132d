"""Forces that YADE applies to two spheres along paths of their overlap, for `dl.check_law`; run under YADE."""

import json
from pathlib import Path

POISSON = 0.2


def ask(name, rule, options, files, contacts, paths):
    """Force [N] of a law in YADE at each overlap [m] of a path, a list per contact; DemlawsError where YADE gives none.

    options: of the law; files: with user-defined laws; contacts: (R [m], E* [Pa], surface of both bodies as a dict).
    """
    import tempfile

    from demlaws.errors import DemlawsError
    from demlaws.yade.run import run

    question = {"law": name, "rule": rule, "options": options, "files": [*files], "contacts": contacts, "paths": paths}
    with tempfile.TemporaryDirectory() as folder:
        asked, answered = Path(folder) / "asked.json", Path(folder) / "answered.json"
        asked.write_text(json.dumps(question))
        process = run(__file__, [asked, answered], capture_output=True, text=True)
        if answered.exists():
            return json.loads(answered.read_text())
    text = [line for line in process.stderr.splitlines() if "Error" in line] or process.stderr.splitlines() or ["no output"]
    raise DemlawsError(f"YADE: {text[-1]:.300}")


def main(asked, answered):
    """Read the question and write the answer."""
    import demlaws as dl

    question = json.loads(Path(asked).read_text())
    for file in question["files"]:
        dl.load_laws(file)
    forces = [_along(question, contact, path) for contact, path in zip(question["contacts"], question["paths"], strict=True)]
    Path(answered).write_text(json.dumps(forces))


def _along(question, contact, path):
    import yade

    import demlaws as dl
    from demlaws.yade import Law2_ScGeom_MindlinPhys_Demlaws, engines
    from demlaws.yade.omega import fixed_pair

    (effective, modulus, surface), omega = contact, yade.O
    radius, young = 2.0 * effective, 2.0 * modulus * (1.0 - POISSON**2)
    omega.reset()
    fixed_pair(("body", "body"), radius, young, POISSON)
    law = Law2_ScGeom_MindlinPhys_Demlaws(
        question["law"], question["rule"], {"body": dl.Surface(**surface)}, **question["options"]
    )
    omega.engines, omega.dt, forces = engines(law), 1e-9, []
    for overlap in path:
        omega.bodies[1].state.pos = yade.Vector3(0, 0, 2.0 * radius - overlap)
        omega.step()
        forces.append(omega.forces.f(1)[2])
    return forces


if __name__ == "__main__":
    import os
    import sys

    main(*sys.argv[1:])
    sys.stdout.flush()
    os._exit(0)  # YADE's own exit takes a second
