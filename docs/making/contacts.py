"""Picture of the contacts of two dumps, coloured by plastic overlap: python docs/making/contacts.py GRAINS CONTACTS PICTURE.

Reads the file that `demlaws contacts --vtk` writes, as ParaView would. Needs pyvista and pillow.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

TITLE = "plastic overlap (µm)\n "
"""Of the bar; the blank line keeps its largest number below it."""


def draw(lines, grains, picture):
    """Contacts as tubes over faint grains."""
    import pyvista
    from PIL import Image

    plotter = pyvista.Plotter(off_screen=True, window_size=(1000, 800))
    spheres = pyvista.PolyData(grains[:, :3])
    spheres["diameter"] = 2 * grains[:, 3]
    ball = pyvista.Sphere(radius=0.5, theta_resolution=24, phi_resolution=24)
    plotter.add_mesh(spheres.glyph(scale="diameter", geom=ball), color="lightgrey", opacity=0.08)
    mesh = pyvista.read(lines).extract_geometry()
    mesh.cell_data[TITLE] = 1e6 * mesh.cell_data["plastic_overlap"]
    tubes = mesh.tube(radius=float(0.12 * grains[:, 3].mean()))
    limit = float(sorted(mesh.cell_data[TITLE])[int(0.98 * mesh.n_cells)])
    bar = {
        "vertical": True,
        "title_font_size": 24,
        "label_font_size": 22,
        "color": "black",
        "position_x": 0.84,
        "position_y": 0.2,
    }
    plotter.add_mesh(tubes, scalars=TITLE, cmap="inferno_r", clim=(0, limit), scalar_bar_args=bar)
    plotter.set_background("white")
    plotter.view_xz()
    plotter.camera.azimuth, plotter.camera.elevation = 20, 12
    plotter.camera.zoom(1.12)
    trimmed(Image.fromarray(plotter.screenshot(return_img=True))).quantize(96).save(picture, optimize=True)


def trimmed(image, margin=10):
    """An image without its white border, but for a margin [pixels]."""
    from PIL import ImageOps

    box = ImageOps.invert(image.convert("L")).point(lambda level: 255 * (level > 4)).getbbox()
    return ImageOps.expand(image.convert("RGB").crop(box), margin, "white")


def main():
    """Contacts by the command, then the picture."""
    import numpy as np

    grains, contacts, picture = sys.argv[1:]
    with tempfile.TemporaryDirectory() as scratch:
        lines = Path(scratch) / "contacts.vtu"
        subprocess.run([sys.executable, "-m", "demlaws", "contacts", grains, contacts, "--vtk", lines], check=True)
        text = Path(grains).read_text().rpartition("ITEM: ATOMS")[2].splitlines()
        names = text[0].split()
        rows = np.array([line.split() for line in text[1:]], float)
        draw(lines, rows[:, [names.index(name) for name in ("x", "y", "z", "radius")]], picture)


if __name__ == "__main__":
    main()
