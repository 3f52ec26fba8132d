"""Programs of studies in the engines: which engines are installed, scripts under YADE and what they answer."""

import json
import subprocess
import tempfile
from pathlib import Path

from demlaws.errors import DemlawsError
from studies.trade.candidates import NAMES


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
