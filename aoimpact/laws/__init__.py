"""Contact laws: a family a file, and the registry of them all.

To add a law, write its class in a file of this folder and import it here: scene files, and tests of
what holds for every law, read `LAWS`. A law is numbers alone; `effective_law` takes the compliance
of the bodies' meshes out of it, for `scene`. `integrate` hands laws to the core; `fem` and
`reduction` know none.
"""

from .curvature import RoundContact, round_contact
from .elastic import Hertz, Linear, PowerLaw
from .given import Tabulated, UserLaw
from .law import (
    ContactLaw,
    CoreLaw,
    Dent,
    HertzianLaw,
    PatchLaw,
    check_width,
    effective_law,
    own_law,
    removable,
    restitution,
)
from .plastic import ElasticPlastic, Thornton, YangSun, yield_force, yield_pressure
from .surfaces import LawFromSurfaces, law_between
from .viscous import HuntCrossley, KelvinVoigt, KuwabaraKono, Tsuji

# Every law by its name; a law between patches is made from one of them.
LAWS: dict[str, type[ContactLaw]] = {
    name: law
    for name, law in globals().items()
    if isinstance(law, type) and issubclass(law, ContactLaw)
    if law not in (ContactLaw, HertzianLaw, PatchLaw)
}
