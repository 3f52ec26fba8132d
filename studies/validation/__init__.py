"""Published and third-party results, compared with our laws in Python and in the engines.

`python -m studies.validation` (`make validation`) runs every row and writes one page; see `report`.
"""
