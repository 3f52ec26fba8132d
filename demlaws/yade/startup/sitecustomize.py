"""What Python does at the start of a process of `demlaws yade run`, whose PYTHONPATH contains this folder.

`demlaws.yade` is imported right after the package yade: a script that loads a saved scene may not import it. The
sitecustomize of the system, which this file hides, is executed, too.
"""

import importlib.abc
import importlib.util
import os
import runpy
import sys

HERE = os.path.dirname(os.path.abspath(__file__))


class _Finder(importlib.abc.MetaPathFinder):
    """Finds yade once, and has demlaws.yade imported after it."""

    def find_spec(self, name, path=None, target=None):
        if name != "yade":
            return None
        sys.meta_path.remove(self)
        spec = importlib.util.find_spec(name)
        if spec is not None and spec.loader is not None:
            execute = spec.loader.exec_module

            def execute_both(module):
                execute(module)
                import demlaws.yade  # noqa: F401

            spec.loader.exec_module = execute_both
        return spec


def _execute_hidden():
    """Execute the next sitecustomize of the path."""
    for folder in sys.path:
        file = os.path.join(folder, "sitecustomize.py")
        if os.path.abspath(folder) != HERE and os.path.isfile(file):
            runpy.run_path(file)
            return


def _join_toolkits():
    """Debian's path file binds mpl_toolkits to the system's matplotlib: where another one comes first, so must its toolkits."""
    toolkits = sys.modules.get("mpl_toolkits")
    for folder in sys.path:
        if os.path.isdir(os.path.join(folder, "matplotlib")):
            beside = os.path.join(folder, "mpl_toolkits")
            if toolkits is not None and os.path.isdir(beside) and beside not in list(toolkits.__path__)[:1]:
                toolkits.__path__ = [beside, *toolkits.__path__]
            return


sys.meta_path.insert(0, _Finder())
_execute_hidden()
_join_toolkits()
