"""Engines as processes of their own."""

import subprocess


def output(command, folder, environment, echo=False, timeout=None):
    """(exit status, lines of output) of a command in `folder`; echo: shown as they come. What stops us stops it, too."""
    lines = []
    with subprocess.Popen(
        command, cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace"
    ) as process:
        try:
            if echo:
                for text in process.stdout:
                    print(text, end="", flush=True)
                    lines.append(text)
                process.wait()
            else:
                lines = process.communicate(timeout=timeout)[0].splitlines(keepends=True)
        except BaseException:
            process.kill()
            raise
    return process.returncode, lines
