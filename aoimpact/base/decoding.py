"""Text of files in the encodings that programs write."""

from __future__ import annotations

import codecs
from contextlib import suppress

# Byte order marks and their encodings. UTF-32 precedes UTF-16, since its mark begins with UTF-16's.
_MARKS = (
    (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)


def decoded(content: bytes) -> str | None:
    """Return the text of a file with "\\n" for each end of a line; None if it is binary.

    The byte order mark tells the encoding; without it, the file is read as UTF-8 or else Latin-1.
    """
    marked = [encoding for mark, encoding in _MARKS if content.startswith(mark)]
    for encoding in marked[:1] or ["utf-8", "latin-1"]:
        with suppress(UnicodeDecodeError):
            text = content.decode(encoding)
            return None if "\0" in text else text.replace("\r\n", "\n").replace("\r", "\n")
    return None
