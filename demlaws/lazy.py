"""Packages whose public names are loaded from their modules on first use, so that importing the package loads nothing."""

import importlib
import sys
import types


class _Package(types.ModuleType):
    """Import would set sub-modules over functions of their names (`build`, `law`): they stay where they are."""

    _homes: dict

    def __getattr__(self, name):
        if name not in self._homes:
            raise AttributeError(f"module {self.__name__!r} has no attribute {name!r}")
        home = importlib.import_module(self._homes[name])
        is_module = home.__name__ == f"{self.__name__}.{name}"  # of a module that has a function of its name, the function
        value = self.__dict__[name] = getattr(home, name, home) if is_module else getattr(home, name)
        return value

    def __setattr__(self, name, value):
        if not (isinstance(value, types.ModuleType) and name in self._homes):
            super().__setattr__(name, value)

    def __dir__(self):
        return sorted({*self._homes, *(name for name in self.__dict__ if name.startswith("__"))})


def load_lazily(package, homes):
    """homes: public name → full name of the module that has it, or that is meant where the names are the same
    and the module has no function of that name."""
    module = sys.modules[package]
    module.__dict__["_homes"] = homes
    module.__class__ = _Package
