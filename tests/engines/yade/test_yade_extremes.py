"""The extremes inside YADE, in small (python -m studies.extremes --yade measures them in full)."""

from studies.extremes import extremes, report


def test_numbers_that_are_none_stop_and_name_the_body(omega):
    from studies.extremes.yade_extremes import Yade

    found = dict(extremes.stops(Yade()))
    assert len(found) == 8 and report.stop_failures("YADE", found.items()) == []
    for what, message in found.items():
        assert "body 2 is at" in message or ("alone" not in what and "contact " in message)
