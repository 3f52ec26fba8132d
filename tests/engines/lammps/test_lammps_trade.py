"""The scene of `python -m studies.trade` in LAMMPS, what a law costs there, and `choose` for it."""

import pytest

import demlaws as dl
from demlaws.errors import DemlawsError
from demlaws.lammps import export, run
from demlaws.liggghts import Grain

pytestmark = pytest.mark.filterwarnings("ignore::demlaws.errors.ValidityWarning")


def test_hertz_of_lammps_itself_as_a_case(tmp_path):
    """Two materials: E* and G* of unlike types as the table's mixing has them; stock binary, no plugin."""
    soft, stiff = dl.Material(5e9, 0.3, density=1200.0), dl.Material(60.6e9, 0.25, density=2650.0)
    grains = [Grain(r, m, dl.Surface(0.0, 2.2)) for r, m in ((0.004, soft), (0.005, stiff))]
    final = {}
    for stock in ("hertz", None):
        folder = tmp_path / str(stock)
        path = export(folder, "hertz", grains, "elastic", count=60, stock=stock, restitution=1.0)
        path.write_text(path.read_text().replace("steps index 20000", "steps index 4000"))
        if stock:
            assert not list(folder.glob("*.tbl")) and "demlaws/" not in path.read_text().split("pair_style", 1)[1]
        final[stock] = run(path, plugin=not stock)["KinEng"][-1]
    assert final["hertz"] == pytest.approx(final[None], rel=1e-4)
    with pytest.raises(DemlawsError, match="stock = 'hertz' with law 'rms'"):
        export(tmp_path, "rms", grains, stock="hertz")
