"""Text of files in the encodings that programs write."""

from __future__ import annotations

import codecs
from contextlib import suppress

# Byte order marks and their encodings; UTF-32 before UTF-16, whose mark begins that of UTF-32.
_MARKS = (
    (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)


def decoded(content: bytes) -> str | None:
    """Return the text of a file with "\\n" for each end of a line; None if it is binary.

    The encoding is that of the byte order mark; else UTF-8, or Latin-1 if the file is not UTF-8.
    """
    marked = [encoding for mark, encoding in _MARKS if content.startswith(mark)]
    for encoding in marked[:1] or ["utf-8", "latin-1"]:
        with suppress(UnicodeDecodeError):
            text = content.decode(encoding)
            return None if "\0" in text else text.replace("\r\n", "\n").replace("\r", "\n")
    return None
