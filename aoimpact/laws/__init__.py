"""Contact laws, one family per file, and their registry `LAWS`.

To add a law, write its class in a file of this folder and import it here: scene files and the tests
common to all laws read `LAWS`. Laws know no bodies. `scene` removes the compliance of the bodies'
meshes by `effective_law`, and `integrate` hands laws to the core; `fem` and `reduction` use no
laws.
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
from .surfaces import ONE_FRAME, LawFromSurfaces, law_between
from .viscous import HuntCrossley, KelvinVoigt, KuwabaraKono, Tsuji

# Laws by class name, except the base classes and `PatchLaw`, which is made from another law.
LAWS: dict[str, type[ContactLaw]] = {
    name: law
    for name, law in globals().items()
    if isinstance(law, type) and issubclass(law, ContactLaw)
    if law not in (ContactLaw, HertzianLaw, PatchLaw)
}
