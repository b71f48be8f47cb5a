"""Contact laws: a family a file."""

from .elastic import Hertz, Linear, PowerLaw
from .law import ContactLaw, PatchLaw
from .patchlaw import check_width, effective_law, own_law, wide_enough
from .plastic import Thornton
from .restitution import restitution
from .tabulated import Tabulated
from .user import UserLaw
from .viscous import (
    Flores,
    Gonthier,
    HerbertMcWhannell,
    HuntCrossley,
    KelvinVoigt,
    KuwabaraKono,
    LankaraniNikravesh,
    LeeWang,
    Tsuji,
)

__all__ = [
    "ContactLaw",
    "Flores",
    "Gonthier",
    "HerbertMcWhannell",
    "Hertz",
    "HuntCrossley",
    "KelvinVoigt",
    "KuwabaraKono",
    "LankaraniNikravesh",
    "LeeWang",
    "Linear",
    "PatchLaw",
    "PowerLaw",
    "Tabulated",
    "Thornton",
    "Tsuji",
    "UserLaw",
    "check_width",
    "effective_law",
    "own_law",
    "restitution",
    "wide_enough",
]
