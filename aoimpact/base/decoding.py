"""Text of files in the encodings that programs write."""

from __future__ import annotations

import codecs

# Encodings by what a file begins with; UTF-32 before UTF-16, with which it begins as well.
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
    encodings = [name for mark, name in _MARKS if content.startswith(mark)][:1]
    for encoding in encodings or ["utf-8", "latin-1"]:
        try:
            text = content.decode(encoding)
        except UnicodeDecodeError:
            continue
        if "\0" in text:
            break
        return text.replace("\r\n", "\n").replace("\r", "\n")
    return None
