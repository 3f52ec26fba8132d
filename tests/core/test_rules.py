"""One record a rule: the kernels are bound to its tag, and the C++ header and the plugins say the same of it."""

import re
from pathlib import Path
from typing import NamedTuple

import pytest

import demlaws as dl
from demlaws.core import dispatch, numba_compat
from demlaws.core.unloading import RULES
from demlaws.laws.registry import registry

PACKAGE = Path(dl.__file__).parent
OWN = {rule.name: rule for definition in registry().values() for rule in definition.rules}
IN_CPP = [rule for rule in (*RULES.values(), *OWN.values()) if rule.number is not None]


def test_histories_of_liggghts_are_the_state_in_its_order():
    sources = "".join(path.read_text() for path in sorted((PACKAGE / "liggghts" / "src").glob("*.h")))
    listed = re.search(r"\[MOST_STATE\] = \{([^}]*)\}", sources).group(1)
    words = [re.sub(r"[A-Z]", lambda m: "_" + m.group().lower(), name) for name in re.findall(r'"demlaws_(\w+)"', listed)]
    for rule in IN_CPP:
        assert tuple(words[: len(rule.state)]) == rule.state


def test_a_second_type_of_the_name_is_refused():
    """The name goes into the symbols of the machine code."""

    class First(NamedTuple):
        k: float

    class Second(NamedTuple):
        k: float

    First.__name__ = Second.__name__ = "SpringOfThisTest"
    First.__module__ = Second.__module__ = "demlaws.laws.made_up"  # a user's would be given another name
    kernel = numba_compat.kernel(lambda p, overlap: 0.5 * p.k * overlap**2)
    dispatch.bind(First, energy=kernel)
    dispatch.bind(First, inverse=numba_compat.kernel(lambda p, force: force / p.k))  # binding again adds
    with pytest.raises(TypeError, match=r"SpringOfThisTest\w*: another law has a type of this name"):
        dispatch.bind(Second, energy=kernel)
