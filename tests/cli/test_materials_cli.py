"""`demlaws materials`."""

from demlaws.cli import main
from demlaws.materials import names, typical


def test_table_has_all_materials(capsys):
    assert main(["materials"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines[1:-1:2]] == names()
    assert max(map(len, lines)) <= 100


def test_one_material_with_its_sources(capsys):
    assert main(["materials", "steel"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert all(" ".join(value.source.split()) in said for value in typical("steel").values())


def test_unknown_material(capsys):
    assert main(["materials", "stel"]) == 2
    assert "did you mean 'steel'" in capsys.readouterr().err
