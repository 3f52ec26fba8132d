"""Memory of the rows of contacts: made by need, returned, limited."""

import numpy as np
import pytest
from yade_scenes import (
    acting,
    advance,
    expected,
    fixed_pair,
    force,
    functor,
    material,
    set_engines,
    still,
    stops,
    under_yade,
    yade,
)

from demlaws.yade import kernel, layout


def mapped_blocks(law):
    return int(np.count_nonzero(law.binding.attachment.rows.blocks))


@pytest.mark.slow
def test_a_hundred_laws_in_four_gigabytes(tmp_path):
    """Of a study whose scenes follow each other. Each law reserved 2.16 GB, and the second is the limit."""
    text = """
import resource
from yade_scenes import *
resource.setrlimit(resource.RLIMIT_AS, (4_000_000_000, 4_000_000_000))
laws = []
for n in range(100):
    yade.O.reset()
    laws.append(acting(functor(label=f"law{n}")))
    assert force() == expected()
    if n == 0:
        first = int(open("/proc/self/statm").read().split()[0])
pages = int(open("/proc/self/statm").read().split()[0]) - first
print("MB", pages * 4096 / 1e6)
"""
    done = under_yade(text, tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    assert float(done.stdout.split("MB")[1]) < 100.0


def test_a_law_of_a_scene_that_is_gone_keeps_few_pages(tmp_path):
    """YADE keeps the functors of a scene after O.reset; of a law 128 kB of addresses of blocks stayed resident."""
    text = """
import gc
from yade_scenes import *
def one():
    yade.O.reset()
    material()
    set_engines(functor())
def resident():
    gc.collect()
    return int(open("/proc/self/statm").read().split()[1]) * 4.096
for _ in range(10):
    one()
first = resident()
for _ in range(60):
    one()
print("kB", (resident() - first) / 60)
"""
    done = under_yade(text, tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    assert float(done.stdout.split("kB")[1]) < 128.0


def test_laws_of_one_kind_share_their_dtypes(omega):
    """YADE keeps the functors of scenes that are gone: a third of what each law kept were dtypes of its own."""
    one, other = functor(label="one").binding.pairs, functor(label="other").binding.pairs
    assert one.row is other.row and one.contact is other.contact and one.saved is other.saved
    assert one.records.dtype is other.records.dtype


def test_rows_are_returned_with_their_scene(omega):
    """By a reset and by another scene; a law that is taken out of the engine list and put back continues its contacts."""
    law = acting(functor())
    assert mapped_blocks(law) == 1
    omega.reset()
    assert mapped_blocks(law) == 0
    acting(law)
    assert mapped_blocks(law) == 1
    omega.resetThisScene()
    still(law)
    assert mapped_blocks(law) == 0
    advance(2)
    assert force() == expected() and mapped_blocks(law) == 1
    omega.engines = []
    set_engines(law)
    advance(2)
    assert force() == expected() and law.contacts().maximum_overlap[0] > 0.0


def test_contacts_of_many_blocks(omega, monkeypatch, tmp_path):
    """More contacts than a block has rows: forces, table, collection, saving."""
    law, stone = functor(), material()
    set_engines(law, 1e-9)
    rows = law.binding.attachment.rows
    law.binding.context["collect_at"] = 10 * layout.ROWS
    assert kernel.new_row(law.binding.context.record, rows.dtype) == rows.blocks[0] > 0
    law.binding.context["rows_used"] = layout.ROWS - 2  # as if so many had been before
    count = 5
    for n in range(count):
        omega.bodies.append(fixed_pair(stone, x=0.05 * n))
    advance(3)
    assert mapped_blocks(law) == 2 and len(list(rows.used())) == 2
    forces = [i.phys.normalForce.norm() for i in omega.interactions if i.isReal]
    assert forces == [expected()] * count
    contacts = law.contacts()
    assert len(contacts) == count and contacts.force == pytest.approx(forces, rel=1e-13)
    law.binding.context["collect_at"] = 1
    advance(101)
    assert law.binding.context["free_count"] == layout.ROWS - 2
    omega.bodies.append(fixed_pair(stone, x=1.0))
    advance(2)
    assert law.binding.context["free_taken"] == 1 and len(law.contacts()) == count + 1
    omega.save(str(tmp_path / "x.yade"))
    omega.load(str(tmp_path / "x.yade"))
    advance(2)
    assert law.binding.context["rows_used"] == count + 1 and mapped_blocks(law) == 1
    assert law.contacts().force == pytest.approx([forces[0]] * (count + 1), rel=1e-13)


def test_a_limit_of_memory_is_one_clear_error(tmp_path):
    """Where the system gives no memory for a block the run stops before the next step, and the contact has no force."""
    text = """
import resource
from yade_scenes import *
law = functor()
still(law)
size = int(open("/proc/self/statm").read().split()[0]) * 4096
size += law.binding.attachment.rows.size - 65536  # less than a block, enough for a message
resource.setrlimit(resource.RLIMIT_AS, (size, size))
try:
    advance(5)
except RuntimeError as error:
    print("STOPPED", error)
print("FORCE", yade.O.interactions[0, 1].phys.normalForce.norm(), yade.O.iter)
resource.setrlimit(resource.RLIMIT_AS, (-1, -1))
"""
    done = under_yade(text, tmp_path)
    assert "0+1 has no memory for its history" in done.stdout and "ulimit -v" in done.stdout, done.stdout + done.stderr
    assert done.stdout.split("FORCE")[1].split()[0] == "0.0"


def test_more_rows_than_there_are_numbers_is_the_same_error(omega):
    law = functor()
    still(law)
    law.binding.context["rows_used"] = layout.ROWS * layout.BLOCKS
    stops("has no memory for its history")


def test_rows_of_another_law_are_not_taken(omega):
    """The marks that contacts of a law had before, in another scene, are not taken: their rows no longer exist."""
    law = acting(functor())
    mark = yade.Vector3(omega.interactions[0, 1].phys.prevU)
    omega.reset()
    still(law)
    omega.step()
    assert law.contacts().force == pytest.approx([force()], rel=1e-13)
    omega.interactions[0, 1].phys.prevU = mark
    assert len(law.contacts()) == 0
    stops("has a history that this process does not have")
