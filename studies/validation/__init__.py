"""The answers that others wrote: closed forms, other codes and published numbers, held against our laws and the engines.

`python -m studies.validation` (`make validation`) runs every row and writes one page; see `report`.
"""
