"""How Sphinx makes the pages: ``make docs``."""

import logging
import sys
from importlib.metadata import version as version_of
from pathlib import Path

import ziamath

sys.path.insert(0, str(Path(__file__).parent / "_ext"))

logging.getLogger("skfem").setLevel(logging.WARNING)  # finite elements tell every step where Sphinx listens

MATH_FONT = Path(ziamath.__file__).parent / "fonts" / "STIXTwoMath-Regular.ttf"  # named in pages.css

project = "multilayer"
author = "the authors of multilayer"
version = release = version_of("multilayer")
extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "numpydoc",
    "myst_parser",
    "sphinx_gallery.gen_gallery",
    "mathml",
    "registered",
]
exclude_patterns = ["_build"]
highlight_language = "none"
nitpicky = True
nitpick_ignore_regex = [("py:.*", r".*")]  # types in docstrings are words for people; pages and labels are checked

html_theme = "furo"
html_title = f"multilayer {release}"
html_static_path = ["_static", str(MATH_FONT)]
html_css_files = ["pages.css"]
html_math_renderer = "mathml"
html_copy_source = False
html_show_copyright = False

myst_enable_extensions = ["deflist", "dollarmath"]
myst_heading_anchors = 3

autosummary_generate = False
autodoc_typehints = "none"
autodoc_member_order = "bysource"
numpydoc_show_class_members = False
numpydoc_attributes_as_param_list = True

sphinx_gallery_conf = {
    "examples_dirs": "../examples/gallery",
    "gallery_dirs": "gallery",
    "filename_pattern": r"\.py$",
    "show_signature": False,
    "download_all_examples": False,
    "show_memory": False,
    "write_computation_times": False,
    "abort_on_example_error": True,
    "within_subsection_order": "FileNameSortKey",
    "copyfile_regex": r".*\.rst",
}
