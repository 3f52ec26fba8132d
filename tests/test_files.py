"""Files that are written and read: whole or not at all, with the rights of the file that they replace."""

import contextlib
import os
import stat
import tempfile
import threading
from pathlib import Path

import pytest

import demlaws as dl
from demlaws.files import as_path, read_text, write_atomically

NAMES = ["", ".", "..", "/", "a\0b", "x" * 300 + ".tbl", "x" * 5000]
PAIR = dl.Contact(4e-3, 32e9)


@pytest.mark.parametrize("name", NAMES, ids=lambda name: repr(name)[:12])
def test_a_name_that_no_file_has_is_one_error(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for use in (
        lambda: write_atomically(name, "text"),
        lambda: read_text(name),
        lambda: dl.Table.load(name),
        lambda: dl.Scene.load(name),
        lambda: dl.surface.read(name, pixel=1e-6),
        lambda: dl.load_laws(name),
        lambda: dl.fit(name, PAIR),
        lambda: dl.plots.save(dl.plots.figure()[0], name),
    ):
        with pytest.raises(dl.DemlawsError) as caught:
            use()
        assert len(str(caught.value)) < 600
    assert list(tmp_path.iterdir()) == []


def test_a_replaced_file_keeps_its_mode(tmp_path):
    for mode in (0o600, 0o664, 0o755):
        file = tmp_path / f"{mode:o}.txt"
        file.write_text("old")
        file.chmod(mode)
        write_atomically(file, "new")
        assert (file.read_text(), stat.S_IMODE(file.stat().st_mode)) == ("new", mode)
    assert len(list(tmp_path.iterdir())) == 3  # no temporary file


@pytest.mark.skipif(os.geteuid() != 0, reason="only root may give a file to another user")
def test_a_read_only_file_is_not_replaced(tmp_path):
    """Its folder allowed it, so that it was, without a word."""
    path = tmp_path / "kept.txt"
    path.write_text("kept")
    path.chmod(0o444)
    with pytest.raises(dl.DemlawsError, match="read-only"):
        write_atomically(path, "new")
    assert path.read_text() == "kept" and list(tmp_path.iterdir()) == [path]


def test_a_replaced_file_keeps_its_owner(tmp_path):
    file = tmp_path / "theirs.txt"
    file.write_text("old")
    os.chown(file, 1234, 5678)
    write_atomically(file, "new")
    assert (file.stat().st_uid, file.stat().st_gid, file.read_text()) == (1234, 5678, "new")


@pytest.mark.skipif(os.geteuid() != 0, reason="only root may become another user")
def test_where_the_group_cannot_be_kept_it_gets_no_rights_of_another_one():
    with tempfile.TemporaryDirectory() as folder:
        os.chmod(folder, 0o777)
        file = Path(folder, "theirs.txt")
        file.write_text("old")
        file.chmod(0o664)
        child = os.fork()
        if child == 0:
            with contextlib.suppress(BaseException):
                os.setgroups([])
                os.setgid(1234)
                os.setuid(1234)
                write_atomically(file, "new")
            os._exit(0)
        os.waitpid(child, 0)
        status = file.stat()
        assert (file.read_text(), stat.S_IMODE(status.st_mode), status.st_gid) == ("new", 0o644, 1234)


def test_a_pipe_is_not_a_table(tmp_path):
    os.mkfifo(tmp_path / "pipe.tbl")
    with pytest.raises(dl.DemlawsError, match="not a regular file"):
        dl.Table.load(tmp_path / "pipe.tbl")
    with pytest.raises(dl.DemlawsError, match="not a regular file"):
        write_atomically(tmp_path / "pipe.tbl", "text")


def test_points_may_come_from_a_pipe(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    writer = threading.Thread(target=lambda: (tmp_path / "pipe").write_text("text"))
    writer.start()
    assert read_text(as_path(tmp_path / "pipe")) == "text"
    writer.join()


def test_every_format_of_a_picture_is_drawn(tmp_path):
    for ending in ("png", "jpg", "svg", "pdf"):
        assert dl.plots.save(dl.plots.figure()[0], tmp_path / f"a.{ending}").stat().st_size > 500
