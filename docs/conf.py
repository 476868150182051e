"""Settings of the documentation site, which ``scripts/docs`` builds from a gathered source."""

from pmmkit.base import __version__

project = "pmmkit"
author = copyright = "The pmmkit developers"
version = release = __version__
extensions = [
    "myst_nb",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx_design",
]
language = "en_GB"
highlight_language = "text"
default_role = "py:obj"

myst_enable_extensions = ["colon_fence", "dollarmath", "html_image"]
myst_heading_anchors = 4
nb_execution_mode = "off"  # executed before, by scripts/documentation/site/notebooks.py

autosummary_generate = False
autodoc_typehints = "none"  # the sections of the docstrings say them
numpydoc_show_class_members = False

html_theme = "pydata_sphinx_theme"
html_title = f"pmmkit {__version__}"
html_copy_source = False
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_sidebars = {"index": [], "gallery": []}
html_theme_options = {
    "logo": {"text": "pmmkit"},
    "navbar_align": "left",
    "header_links_before_dropdown": 7,
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": ["last-updated"],
    "show_toc_level": 2,
    "navigation_with_keys": False,
}
