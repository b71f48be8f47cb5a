"""The command line: arguments in, files and text out, nothing computed.

main.py has the commands, files.py what `run --out` writes. Nothing imports it.
"""

from .main import main
