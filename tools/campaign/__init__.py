"""Random scenes, decks and malformed inputs: from tools/, ``python -m campaign --help``."""
