"""scipy.sparse, imported when first used, since impacts of rigid bodies do not need it.

Importing scipy.sparse takes a third of the first impact of rigid bodies in a fresh process.
"""

from typing import Any


def __getattr__(name: str) -> Any:
    import scipy.sparse

    return getattr(scipy.sparse, name)
