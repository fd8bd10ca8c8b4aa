"""Build hook: the README as the description of the package.

Links and pictures of the README are relative, which only works in a checkout. With the address of
the repository in SUBSEA_REPOSITORY (https://HOST/OWNER/NAME) they lead there, to the files of this
version; without it the description has neither pictures nor links to files.
"""

import os
import re
from pathlib import Path
from typing import Any

from hatchling.metadata.plugin.interface import MetadataHookInterface

PICTURE = re.compile(r"^!\[[^\]]*\]\((?!https?:)[^)]+\)\n\n?", re.MULTILINE)
LINK = re.compile(r"(!?)\[([^\]]*)\]\((?!https?:|#)([^)]+)\)")


class PackageReadme(MetadataHookInterface):
    """Sets the description and the addresses of the package."""

    def update(self, metadata: dict[str, Any]) -> None:
        """Set `readme`, and `urls` if the address is known."""
        root = Path(self.root)
        repository = os.environ.get("SUBSEA_REPOSITORY", "").rstrip("/")
        source = (root / "subsea" / "__init__.py").read_text(encoding="utf-8")
        [version] = re.findall(r'^__version__ = "(.+)"$', source, re.MULTILINE)
        text = description((root / "README.md").read_text(encoding="utf-8"), repository, version)
        metadata["readme"] = {"content-type": "text/markdown", "text": text}
        if repository:
            metadata["urls"] = {
                "Source": repository,
                "Changelog": f"{repository}/blob/v{version}/CHANGELOG.md",
            }


def description(readme: str, repository: str, version: str) -> str:
    """Return the README with absolute links; without pictures and links for no `repository`."""
    if not repository:
        return LINK.sub(r"\2", PICTURE.sub("", readme))

    def link(match: "re.Match[str]") -> str:
        picture, text, path = match.groups()
        kind = "raw" if picture else "blob"
        return f"{picture}[{text}]({repository}/{kind}/v{version}/{path})"

    return LINK.sub(link, readme)
