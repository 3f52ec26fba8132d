"""Functions whose source text is written by the program: the package's only `exec`."""


def function(arguments, lines, names):
    """The function of these arguments (text) whose body is these lines (text) and whose globals are `names` (a dict).

    >>> function("x", ["y = factor * x", "return y + 1.0"], {"factor": 3.0})(2.0)
    7.0
    """
    names = dict(names)
    exec(f"def function({arguments}):\n" + "".join(f"    {line}\n" for line in lines), names)
    return names["function"]
