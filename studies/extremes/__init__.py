"""Every law, rule and evaluation on extreme paths and contacts, in Python and inside the engines."""
