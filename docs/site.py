"""Add README, CONTRIBUTING and CHANGELOG to the site."""

import re
from pathlib import Path
from typing import Any

from mkdocs.structure.files import File, Files

ROOT = Path(__file__).parents[1]
PAGES = {
    "README.md": "index.md", "CONTRIBUTING.md": "contributing.md", "CHANGELOG.md": "changelog.md",
}  # fmt: skip


def on_files(files: Files, config: Any) -> Files:
    """Add the files, with links relative to docs/."""
    for name, page in PAGES.items():
        files.append(File.generated(config, page, content=moved((ROOT / name).read_text())))
    return files


def moved(text: str) -> str:
    """A page of the project's root, as a page of docs/."""
    text = text.replace("](docs/", "](")
    for name, page in PAGES.items():
        text = re.sub(rf"\]\({re.escape(name)}(#[^)]*)?\)", rf"]({page}\1)", text)
    return text


def on_page_markdown(text: str, **unused: Any) -> str:
    """Make links to pages of the project's root lead to those of the site."""
    for name, page in PAGES.items():
        text = text.replace(f"](../../{name}", f"](../{page}")
    return text
