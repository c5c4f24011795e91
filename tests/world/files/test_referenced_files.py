"""Materials that a mesh names: all lines of them, in a time that does not grow with its lines."""

import re
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.world.files.referenced_files import find_referenced_files
from tests.profiles import num_cases

# What Drake's reader takes for a line of materials.
LINE = re.compile(rb"^[ \t]*mtllib[ \t]+(.+?)\s*$", re.MULTILINE)
NAMES = st.sampled_from([b"a.mtl", b"b c.mtl", b"c.mtl  ", b"x a.mtl", b" ", b"", b"mtllib x"])
LINES = st.tuples(
    st.sampled_from([b"", b" \t", b"# "]),
    st.sampled_from([b"mtllib", b"mtllib", b"mtllibs", b"v 0 0 0"]),
    st.sampled_from([b" ", b"\t ", b""]),
    NAMES,
    st.sampled_from([b"\n", b"\r\n", b"\n \n", b"\r", b""]),
).map(b"".join)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with two materials."""
    made = tmp_path_factory.mktemp("meshes")
    for name in ("a.mtl", "b c.mtl", "c.mtl", "x"):
        (made / name).write_bytes(b"newmtl red")
    return made


@settings(max_examples=num_cases(60, 2000))
@given(lines=st.lists(LINES, max_size=6))
def test_every_material_that_is_named_in_a_line_is_found(folder: Path, lines: list[bytes]) -> None:
    mesh, content = folder / "mesh.obj", b"".join(lines)
    mesh.write_bytes(content)
    named = [line.decode() for line in LINE.findall(content)]
    words = {*named, *(word for name in named for word in name.split())}
    expected = {name for name in words if (folder / name).is_file()}
    found = find_referenced_files(mesh)
    assert {*found.content} - {"mesh.obj"} == expected - {"mesh.obj"}
