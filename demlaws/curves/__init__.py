"""Curves of first loading: closed forms, tables, their files, and curves made of functions or measured points."""
