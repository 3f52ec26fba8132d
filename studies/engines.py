"""Programs of studies in the engines: which engines are installed, scripts under YADE and what they answer."""

import json
import subprocess
import tempfile
from pathlib import Path

from demlaws.errors import DemlawsError
from demlaws.lammps.run import versions as lammps_versions
from demlaws.liggghts.build import library_path
from demlaws.liggghts.run import versions as liggghts_versions
from demlaws.yade.run import command, environment


def available(engine):
    """None where the engine can be started, else the line with the reason."""
    try:
        if engine == "yade":
            environment()
        elif engine == "liggghts":
            liggghts_versions()
            library_path()
        else:
            lammps_versions()
    except DemlawsError as error:
        return str(error)
    return None


def under_yade(script, given, progress=lambda text: None):
    """What a script of studies/ (path there) that ends with `under_yade.serve` answers under YADE.

    progress(text): called for each of its lines PROGRESS text.
    """
    with tempfile.TemporaryDirectory() as scratch:
        request, answer = Path(scratch) / "given.json", Path(scratch) / "found.json"
        request.write_text(json.dumps(given))
        line = command(Path(__file__).parent / script, [request, answer])
        pipes = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
        with subprocess.Popen(line, env=environment(), text=True, errors="replace", **pipes) as process:
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
        if not answer.is_file():
            raise DemlawsError(f"YADE stopped (exit {process.returncode}): {noise.strip()}")
        return json.loads(answer.read_text())
