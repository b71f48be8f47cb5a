"""The library of contact laws, by name."""

from .law import ContactLaw, PatchLaw
from .laws_elastic import Hertz, Linear, PowerLaw
from .laws_plastic import Thornton
from .laws_table import Tabulated
from .laws_user import UserLaw
from .laws_viscous import (
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
]
