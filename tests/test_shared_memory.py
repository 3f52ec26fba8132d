"""Shared memory of MPICH that the tests clear away is that of their own killed processes."""

import mmap

import processes


def test_only_what_this_run_left_and_nobody_uses(monkeypatch, tmp_path):
    names = ("mpich_shm_of_others", "mpich_shm_in_use", "mpich_shm_left_over")
    others, used, left = (tmp_path / name for name in names)
    for file in (others, used, left):
        file.write_bytes(b"0" * 4096)
    monkeypatch.setattr(processes, "shared_memory", lambda: {others, used, left})
    with open(used, "r+b") as file, mmap.mmap(file.fileno(), 0):
        processes.remove_shared_memory({others})
        assert [file.exists() for file in (others, used, left)] == [True, True, False]
