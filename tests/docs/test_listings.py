"""The helper that runs the listings of a page finds what differs."""

import listings
import pytest


def test_numbers_may_differ_within_the_tolerance_and_words_may_not():
    assert listings.same(["force 1.00 N", "..."], "first\nforce 1.005 N\nmore", 0.01)
    assert not listings.same(["force 1.00 N"], "force 1.02 N", 0.01)
    assert not listings.same(["force 1.00 N"], "farce 1.00 N", 0.01)
    assert listings.same(["a   1.0", "b -2e3"], "a 1.0\n b -2000", 0.01)
    assert listings.same(["x", "...", "3 4 ..."], "x 1 2 30 3 4 5", 0.01)
    assert not listings.same(["x", "...", "3 5 ..."], "x 1 2 30 3 4 5", 0.01)
    assert listings.same(["x ... end 3"], "x 1 2 end 3", 0.01)


def test_a_page_is_run(tmp_path):
    page = tmp_path / "page.md"
    page.write_text(
        "<!-- file: a.txt -->\n```\nheld 5.0\n```\n"
        "<!-- run -->\n```console\n$ cat a.txt\nheld 5.01\n$ cat \\\n    a.txt\nheld 7\n```\n"
    )
    assert listings.run(page, tmp_path) == [("cat \\\n    a.txt", "held 5.0\n")]
    page.write_text("```console\n$ false\n```\n")
    with pytest.raises(AssertionError):  # a listing without a mark
        listings.run(page, tmp_path)
