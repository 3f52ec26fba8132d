"""The models as a source of LIGGGHTS: one file that is copied into src. Only the standard library."""

import demlaws
from demlaws.liggghts.build import PLUGIN
from demlaws.plugins.engines import SHARED, inlined, write_sources

NAME = PLUGIN.source
"""No name of a header: LIGGGHTS would combine a normal_model_*.h with each of its own models."""


THEN = "now build LIGGGHTS: cmake finds the file by itself, if it is run again, and so does make"


def source(folder):
    """Write demlaws_liggghts.cpp into `folder`, LIGGGHTS's src; an earlier one is replaced. Returns lines for the user.

    For LIGGGHTS 3.8.0. Built with this file, LIGGGHTS has the models without any plugin, also as a static executable, and reads
    the inputs of the plugin and its restart files.
    """
    head = f"// The models of demlaws {demlaws.__version__}, written by `demlaws liggghts source`. Licence: GPL-2.0-or-later."
    text = "\n".join([head, *inlined(NAME, (PLUGIN.sources, SHARED))]) + "\n"
    return write_sources(folder, {NAME: text}, "normal_model_hertz.h", THEN)
