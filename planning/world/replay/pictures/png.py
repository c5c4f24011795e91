"""png(): a picture as a file, the same bytes for the same picture."""

import struct
import zlib

import numpy as np
from jaxtyping import Float64


def png(picture: Float64[np.ndarray, "h w 3"]) -> bytes:
    """Return a PNG file of a picture, red, green and blue, 0 to 1.

    W3C, "Portable Network Graphics (PNG) Specification", 2003; 8 bits, each row as its difference
    from the one above.
    """
    rows = (picture * 255).round().clip(0, 255).astype(np.uint8)
    height, width = rows.shape[:2]
    above = np.concatenate([np.zeros_like(rows[:1]), rows[:-1]])
    up = np.full((height, 1), 2, dtype=np.uint8)
    body = np.concatenate([up, (rows - above).reshape(height, -1)], axis=1)
    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    chunks = [(b"IHDR", head), (b"IDAT", zlib.compress(body.tobytes(), 9)), (b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(_chunk(name, content) for name, content in chunks)


def _chunk(name: bytes, content: bytes) -> bytes:
    check = zlib.crc32(name + content)
    return struct.pack(">I", len(content)) + name + content + struct.pack(">I", check)
