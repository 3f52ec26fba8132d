"""A table has the same bytes on every processor: a restart compares it with one that was made elsewhere."""

from pathlib import Path

import pytest
from processes import finish, start

TESTS = Path(__file__).parents[1]
CODE = f"""
    import sys, warnings, zlib
    sys.path.insert(0, {str(TESTS)!r})
    warnings.simplefilter("ignore")
    from examples import GRANITE, make
    from demlaws.laws.registry import registry
    pairs = [(name, definition.default_rule()) for name, definition in registry().items()]
    for name, rule in [*pairs, ("pohrt-popov", "table"), ("rms", "table")]:
        lines = make(name, rule).tabulate(1e-5, max_force=100.0)._compose()[0].splitlines()[:-1]
        lines = [line for line in lines if not line.startswith(b"option_surface")]  # the map is made here, by an FFT
        print(name, rule, f"{{zlib.crc32(b''.join(lines)):08x}}")
"""
OLD = {
    "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-AVX512F",
    "NPY_DISABLE_CPU_FEATURES": "AVX2 FMA3 AVX512F AVX512CD AVX512_SKX",
}
"""The C library and numpy as on a processor without fused multiply-add."""
PROCESSORS = {
    "generic": {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": "", **OLD},
    "haswell": {"NUMBA_CPU_NAME": "haswell", "NUMBA_CPU_FEATURES": ""},
}


@pytest.mark.slow
@pytest.mark.parametrize("name", PROCESSORS)
def test_a_table_of_every_law_on_another_processor(name):
    """Compiled code fuses sums and products where it can: 17 digits of a row were then others."""
    here, there = (finish(process).split("\n") for process in (start(CODE), start(CODE, **PROCESSORS[name])))
    assert len(here) > 10
    assert [pair for pair in zip(here, there, strict=True) if pair[0] != pair[1]] == []
