"""The command line: arguments in, files and text out, nothing computed.

main.py has the commands, files.py the output of `run --out`. No other folder imports this one.
"""

from .main import main
