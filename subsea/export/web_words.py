"""All words of the page of an exported scene, by the names that it gives them.

`{{name}}` in `assets/web/index.html` stands for one; its script has all languages in `scene.json`.
They are English and are translated when a scene is written.
"""

from collections.abc import Iterable
from typing import Any

from subsea.base.language import LANGUAGES, translated

WORDS = {
    "skip": "Skip to the list of fishes",
    "sea": "The sea",
    "loading": "Loading the sea …",
    "loaded": "Loaded",
    "script": "This page needs JavaScript.",
    "webgl": "This browser or its settings do not allow WebGL 2, with which the sea is drawn. "
    "The file can still be downloaded.",
    "lost": "The graphics driver has stopped. Load the page again.",
    "failed": "The scene could not be loaded.",
    "fishes": "Fishes",
    "play": "Play",
    "pause": "Pause",
    "time": "Time",
    "view": "View",
    "film": "As filmed",
    "orbit": "Around a place",
    "fly": "Fly",
    "about": "Help and licence",
    "help": "Drag to look around, scroll or pinch to go nearer. Keys: arrows turn, W and S go "
    "ahead and back, A and D aside, E and Q up and down, space plays, Escape lets a fish go.",
    "download": "Download the scene (glTF, {size} MB)",
}


def words_by_language(names: Iterable[str] = ()) -> dict[str, dict[str, Any]]:
    """The words in every language, by its code, and its `names` of the scene and its species."""
    known = tuple(names)
    return {
        code: {name: translated(text, code) for name, text in WORDS.items()}
        | {"names": {name: translated(name, code) for name in known}}
        for code in LANGUAGES
    }
