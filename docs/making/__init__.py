"""What the site makes of the package: pages of laws, rules, commands, errors; formulae; docstrings. Used by docs/conf.py."""
