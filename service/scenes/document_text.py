"""SceneText: a scene's document as text, object by object, so that an edit writes what it edits.

Of ten thousand objects all but a few are after an edit what they were before. Their texts stay, and
so do their values: nothing is read, validated or written for them.
"""

import threading
from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass, replace

from pydantic import ValidationError

from planning import Scene
from planning.domain.geometry.unchecked_pair import UncheckedPair
from planning.domain.scene.scene import SceneObject
from planning.world.documents.scene_document import ObjectDocument, SceneDocument
from planning.world.documents.scene_writer import object_document, scene_document
from service.jobs.json_text import Encoded, encode
from service.scenes.models.pairs import unchecked_pairs

_MOST_OBJECTS = 10_000
# As many as there are worlds in a worker; the texts of revisions are mostly the same.
_MOST_KEPT = 8

type Pairs = tuple[UncheckedPair, ...]


@dataclass(frozen=True)
class SceneText:
    """The document of a scene.

    Attributes:
        rest: All of it but the objects.
        objects: The JSON text of each object.
    """

    rest: SceneDocument
    objects: tuple[str, ...]

    @classmethod
    def of(cls, document: SceneDocument) -> "SceneText":
        """Return a document object by object."""
        rest = document.model_copy(update={"objects": []})
        return cls(rest, tuple(map(_text, document.objects)))

    @property
    def whole(self) -> Encoded:
        """The JSON text of the document; read again it gives the same scene, bit for bit."""
        plain = self.rest.model_dump(mode="json", exclude_none=True)
        objects = f"[{','.join(self.objects)}]"
        members = [
            f"{encode(name)}:{objects if name == 'objects' else encode(part)}"
            for name, part in plain.items()
        ]
        return Encoded(f"{{{','.join(members)}}}")

    def after(self, before: Scene, edited: Scene) -> "tuple[SceneText, Scene] | None":
        """Return the text of a scene that was edited, and the scene that it says.

        None if it says what no document may: then the whole document tells what is wrong.

        Args:
            before: The scene that this text describes.
            edited: The same after an edit.
        """
        if len(edited.objects) > _MOST_OBJECTS:
            return None
        bare = replace(edited, objects=())
        try:
            rest = scene_document(bare, previous=self.rest)
            texts, objects = self._after(before.objects, edited.objects)
        except ValidationError:
            return None
        scene = replace(rest.value(), objects=objects, files=edited.files)
        return SceneText(rest, texts), scene

    def _after(
        self, before: Sequence[SceneObject], edited: Sequence[SceneObject]
    ) -> tuple[tuple[str, ...], tuple[SceneObject, ...]]:
        # All but a few are in their places, and only those few are looked for by name.
        rows = [row for row, (a, b) in enumerate(zip(before, edited, strict=False)) if a is not b]
        rows += range(len(before), len(edited))
        wanted = {edited[row].name for row in rows}
        known = {
            same.name: (text, same)
            for text, same in zip(self.objects, before, strict=True)
            if same.name in wanted
        }
        texts = [*self.objects[: len(edited)], *[""] * (len(edited) - len(before))]
        objects = list(edited)
        for row in rows:
            value = edited[row]
            texts[row], objects[row] = self._again(value, *known.get(value.name, ("", None)))
        return tuple(texts), tuple(objects)

    @staticmethod
    def _again(value: SceneObject, text: str, same: SceneObject | None) -> tuple[str, SceneObject]:
        """Return text and value of an object: as they were if it is the same as before."""
        if same is not None and (value is same or value == same):
            return text, same
        document = object_document(value)
        return _text(document), document.value()


_recent: OrderedDict[str, SceneText] = OrderedDict()
_unchecked: OrderedDict[int, tuple[Pairs, Encoded]] = OrderedDict()
_lock = threading.Lock()


def keep_text(digest: str, text: SceneText) -> None:
    """Keep the text of a scene for its next edit in this process."""
    with _lock:
        _recent[digest] = text
        _recent.move_to_end(digest)
        while len(_recent) > _MOST_KEPT:
            _recent.popitem(last=False)


def kept_text(digest: str) -> SceneText | None:
    """Return the text of a scene if it is here."""
    with _lock:
        return _recent.get(digest)


def unchecked_text(pairs: Pairs) -> Encoded:
    """Return the JSON of pairs that no check looks at; of the very same tuple, the same text.

    Those of a scene's revisions are mostly one and the same.
    """
    with _lock:
        known = _unchecked.get(id(pairs))
        # The pairs are held with their text, so that no other tuple has their id.
        if known is None:
            known = pairs, Encoded(encode(unchecked_pairs(pairs)))
        _unchecked[id(pairs)] = known
        _unchecked.move_to_end(id(pairs))
        while len(_unchecked) > _MOST_KEPT:
            _unchecked.popitem(last=False)
        return known[1]


def _text(document: ObjectDocument) -> str:
    return encode(document.model_dump(mode="json", exclude_none=True))
