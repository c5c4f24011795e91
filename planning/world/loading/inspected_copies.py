"""inspect_copy(): inspection of a description in the store, remembered: copies never change.

Reading and checking a description takes a quarter of the time in which a robot is loaded, and each
edit of a scene that moves an object of Drake's model loads its robots again.
"""

import threading
from collections import OrderedDict
from pathlib import Path

from planning.world.models.model_file import ModelFile, inspect_model

# Of a description of a thousand lines it is some kilobytes.
_MAX_FILES = 64
_files: OrderedDict[tuple[Path, Path], ModelFile] = OrderedDict()
_lock = threading.Lock()


def inspect_copy(file: Path, converted_meshes: Path) -> ModelFile:
    """Return the data of a description; raises as `inspect_model`.

    Args:
        file: The description, in a folder of a `FileStore` whose bytes were just compared: its name
            stands for the bytes of all files in it.
        converted_meshes: Folder of meshes converted from those that Drake does not read.
    """
    key = file, converted_meshes
    with _lock:
        found = _files.get(key)
    if found is not None:
        return found
    found = inspect_model(file, converted_meshes)
    if found.rewritten is None:  # else it names converted meshes, which may be removed
        with _lock:
            _files[key] = found
            while len(_files) > _MAX_FILES:
                _files.popitem(last=False)
    return found
