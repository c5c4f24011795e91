"""find_referenced_files(): every file that a robot description or a mesh refers to.

A description names meshes, textures and further descriptions; a mesh names materials, textures
and buffers. Every named file that exists counts, whether or not a parser will read it.
"""

import json
import os
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path
from typing import Any
from urllib.parse import unquote
from xml.etree import ElementTree as ET
from xml.sax.saxutils import escape, unescape

from planning.errors import AssetNotFound, ModelInvalid
from planning.world.models.model_file import PACKAGE, package_folder, parse_xml_or_none

_DESCRIPTIONS = (".urdf", ".sdf", ".xml")
_FOLDERS = ("meshdir", "texturedir", "assetdir")
# A scan of a factory hall has some hundred megabytes.
_MAX_BYTES = 2**30

_MATERIALS = re.compile(rb"[ \t]*mtllib[ \t]+(.+?)\s*")
_TEXTURES = re.compile(
    rb"^[ \t]*(?:map_\w+|bump|disp|decal|refl|norm)[ \t]+(.+?)\s*$", re.MULTILINE
)
_ABSOLUTE = re.compile(rb"(?<=[\"'>])(\s*)((?:file://)?/[^\"'<>]*?)(\s*)(?=[\"'<])")


@dataclass(frozen=True)
class ReferencedFiles:
    """Contents of all files of a description or mesh, read once.

    Attributes:
        folder: Common folder of all of them.
        content: Their bytes, by path relative to it.
        main: Path of the file that names the others.
    """

    folder: Path
    content: dict[str, bytes]
    main: str

    def path(self, file: Path) -> str:
        """Return the path of one of the files relative to the folder."""
        return _absolute_path(file).relative_to(self.folder).as_posix()


def find_referenced_files(main: Path, companions: Sequence[Path] = ()) -> ReferencedFiles:
    """Return a file and the files that it names, directly or through others.

    Absolute paths in descriptions become relative ones, so that the files can be moved.

    Args:
        main: A robot's description or a mesh.
        companions: Further files that go with it, if they exist.

    Raises:
        AssetNotFound: A file cannot be read, or a mesh is in a package that does not exist.
        ModelInvalid: The files are too large.
    """
    search = _Search(_absolute_path(main))
    search.run([_absolute_path(file) for file in companions])
    folders = [file.parent for file in (*search.content, *search.packages)]
    folder = Path(os.path.commonpath(folders))
    content = {
        file.relative_to(folder).as_posix(): search.relocated(file) for file in search.content
    }
    return ReferencedFiles(folder, content, search.main.relative_to(folder).as_posix())


@dataclass
class _Search:
    """Search of files, with those found so far by absolute path.

    Attributes:
        main: First file.
        content: Bytes of each file.
        packages: Folders of packages; their names count, so they are no anchors themselves.
        relative_names: Names in descriptions, relative to any of `bases`.
        bases: Folders that descriptions are in, or that they declare for their meshes.
        candidates: Files that are named in one way only.
        with_absolute_paths: Descriptions that name something by an absolute path.
    """

    main: Path
    content: dict[Path, bytes] = field(default_factory=dict)
    packages: set[Path] = field(default_factory=set)
    relative_names: set[str] = field(default_factory=set)
    bases: set[Path] = field(default_factory=set)
    candidates: set[Path] = field(default_factory=set)
    with_absolute_paths: set[Path] = field(default_factory=set)

    def run(self, companions: Sequence[Path]) -> None:
        """Read until nothing new is named."""
        self.candidates |= {self.main, *companions}
        while new := {f for f in self._candidate_files() if f not in self.content and f.is_file()}:
            for file in sorted(new):
                self._read(file)

    def relocated(self, file: Path) -> bytes:
        """Return the bytes of a file with the absolute paths of found files made relative.

        A description's paths are relative to the folder of the first one, or in MJCF to its
        declared mesh folder.

        Raises:
            ModelInvalid: Another absolute path is left, which would be read from its place on disk.
        """
        if file not in self.with_absolute_paths:
            return self.content[file]
        content = _ABSOLUTE.sub(self._relative, self.content[file])
        root = parse_xml_or_none(content)
        for element in () if root is None else root.iter():
            for text in (*_referenced_names(element), *_declared_folders(element)):
                if _is_absolute_name(text) and Path(text.removeprefix("file://")).exists():
                    message = (
                        f"{file.name} refers to {text!r} by a path that cannot be copied with "
                    )
                    message += "the scene: use a path relative to the description, or package://"
                    raise ModelInvalid(message, {"file": str(file), "reason": message})
        return content

    def _relative(self, match: re.Match[bytes]) -> bytes:
        text = unescape(match[2].decode("utf-8", "replace"))
        path = _absolute_path(Path(text.removeprefix("file://")))
        if path not in self.content and path not in self.bases:
            return match[0]
        mesh_folders = sorted(base for base in self.bases if base != self.main.parent)
        is_mjcf = self.main.suffix.lower() == ".xml" and path in self.content
        base = mesh_folders[0] if is_mjcf and mesh_folders else self.main.parent
        return match[1] + escape(os.path.relpath(path, base)).encode() + match[3]

    def _candidate_files(self) -> Iterator[Path]:
        yield from self.candidates
        for base, name in product(sorted(self.bases), sorted(self.relative_names)):
            yield _absolute_path(base / name)

    def _read(self, file: Path) -> None:
        try:
            self.content[file] = content = file.read_bytes()
        except OSError as fault:
            message = f"cannot read {file}: {fault.strerror}"
            raise AssetNotFound(message, {"uri": str(file), "known": []}) from fault
        if sum(map(len, self.content.values())) > _MAX_BYTES:
            message = f"{self.main.name}: its files are larger than {_MAX_BYTES} bytes in total"
            raise ModelInvalid(message, {"file": str(self.main), "reason": message})
        if file.suffix.lower() in _DESCRIPTIONS:
            self._read_description(file, content)
        else:
            self.candidates |= {
                _absolute_path(file.parent / name) for name in _names_in_mesh(file, content)
            }

    def _read_description(self, file: Path, content: bytes) -> None:
        if file.suffix.lower() == ".urdf":
            self.candidates.add(file.with_suffix(".srdf"))
        root = parse_xml_or_none(content)
        if root is None:
            return  # the inspection reports it
        self.bases.add(self.main.parent)
        for element in root.iter():
            folders, texts = _declared_folders(element), _referenced_names(element)
            self.bases |= {_absolute_path(self.main.parent / folder) for folder in folders}
            if any(map(_is_absolute_name, (*folders, *texts))):
                self.with_absolute_paths.add(file)
            for text in texts:
                self._add(file, element.tag.rsplit("}", 1)[-1], text)

    def _add(self, file: Path, tag: str, text: str) -> None:
        package = PACKAGE.match(text)
        if package is None:
            self.relative_names.add(text.removeprefix("file://"))
            self.candidates.add(_absolute_path(file.parent / text.removeprefix("file://")))
            return
        try:
            folder = package_folder(file, package[1], text)
        except AssetNotFound:
            if tag == "mesh":
                raise
            return
        self.packages.add(folder)
        self.candidates |= {folder / "package.xml", _absolute_path(folder / package[2])}
        for model in folder.joinpath(package[2]).glob("*.sdf"):  # an SDF includes folders as well
            self.candidates |= {model, model.with_name("model.config")}


def _referenced_names(element: ET.Element) -> list[str]:
    is_uri = element.tag.rsplit("}", 1)[-1] == "uri"
    texts = (element.get("filename"), element.get("file"), element.text if is_uri else None)
    return [text.strip() for text in texts if text and text.strip()]


def _declared_folders(element: ET.Element) -> list[str]:
    return [element.get(attribute, "") for attribute in _FOLDERS if element.get(attribute)]


def _is_absolute_name(text: str) -> bool:
    return text.startswith(("/", "file://"))


def _names_in_mesh(file: Path, content: bytes) -> list[str]:
    """Return the names in a mesh or a material, relative to its own folder."""
    match file.suffix.lower():
        case ".obj":
            return _lines_and_words(_materials(content))
        case ".mtl":
            return _lines_and_words(_TEXTURES.findall(content))
        case ".gltf":
            return _gltf_uris(content)
        case _:
            return []


def _materials(content: bytes) -> list[bytes]:
    """Return what the lines of materials name; a mesh has megabytes, and a line or two of these."""
    found: list[bytes] = []
    at = content.find(b"mtllib")
    while at >= 0:
        begin, end = content.rfind(b"\n", 0, at) + 1, content.find(b"\n", at)
        end = len(content) if end < 0 else end
        match = _MATERIALS.fullmatch(content, begin, end)
        found += [match[1]] if match else []
        at = content.find(b"mtllib", end)
    return found


def _lines_and_words(lines: list[bytes]) -> list[str]:
    """Return every line, and its words: names may contain spaces, and options come before them."""
    texts = [line.decode("utf-8", "replace") for line in lines]
    return [*texts, *(word for text in texts for word in text.split())]


def _gltf_uris(content: bytes) -> list[str]:
    try:
        document: Any = json.loads(content)
        entries = [*document.get("buffers", []), *document.get("images", [])]
        uris = [str(entry.get("uri", "")) for entry in entries]
    except (ValueError, AttributeError, TypeError, RecursionError):
        return []  # the loader reports it
    return [unquote(uri) for uri in uris if uri and not uri.startswith("data:")]


def _absolute_path(path: Path) -> Path:
    """Return a path from the root on, without steps back, as Drake resolves them."""
    return Path(os.path.abspath(path))  # noqa: PTH100  (resolve() would follow links)
