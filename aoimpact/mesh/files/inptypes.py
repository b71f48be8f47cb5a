"""Element types of Abaqus and CalculiX, and the keywords that say nothing of mesh and groups."""

from __future__ import annotations

import re
from dataclasses import dataclass

from .rawmesh import LINES, SOLIDS, SURFACES

__all__ = ["CONNECTIONS", "UNSUPPORTED", "ElementType", "element_type", "harmless", "is_side"]


@dataclass(frozen=True)
class ElementType:
    """A type of elements.

    Attributes
    ----------
    kind : str
        meshio's name; empty if the elements are only listed.
    n_nodes : int
        0 if the elements are only listed.
    """

    kind: str
    n_nodes: int

    @property
    def solid(self) -> bool:
        """Whether the elements are solids of a structure."""
        return self.kind in SOLIDS.values()


# Nodes are in meshio's order, but those of C3D27: there the middle comes before the faces.
_SOLID = re.compile(r"C3D(4|5|6|8|10|13|15|20|27)(?!.*V)[A-Z]{0,4}")

# Shells, membranes, rigid and plane elements, of which the first digits count the nodes.
_SURFACE = re.compile(
    r"(?:D?S|US|STRI|M3D|R3D|SFM3D|CPS|CPE|CAX|DC2D|DCAX|AC2D|ACAX)(65|3|4|6|8|9)(?!\d)[A-Z0-9]*"
)

# Of these, the ones that meshers write for the sides of solids.
_SIDE = re.compile(r"CP[SE]\d|CAX\d|SFM3D")

_LINE = re.compile(r"T[23]D([23])[A-Z]{0,2}")

# Elements of a number of nodes that may vary, or of shapes that no mesh of solids has.
_LISTED = re.compile(
    r"(?:B[23]\d|PIPE|ELBOW|FRAME|MASS$|ROTARYI$|HEATCAP$|SPRING|DASHPOT|JOINT|CONN|GAP|DGAP|DCOUP"
    r"|ITS|ITT|ISL|IRS|LS\d|COH|GK|SC[68]R|CSS8|SFM|MAX|MCL|CCL|CIN|CPEG|CGAX|CAXA|CGPE|SAX|SAXA"
    r"|DSAX|RAX2|RB[23]D|R2D2|AC1D|AC3D|ACIN|ASI|DC1D|DCC|DC3D|Q3D|EMC|EC3D|FC3D|F3D|PC3D|PD3D|PSI"
    r"|DRAG|KSP|WARP|D$|V?U\d|Z\d)[A-Z0-9-]*"
)


def element_type(name: str) -> ElementType | None:
    """Return what is known of a type of elements, or None.

    Parameters
    ----------
    name : str
        In capitals, as in "C3D8R".
    """
    for pattern, kinds in ((_SOLID, SOLIDS), (_SURFACE, SURFACES), (_LINE, LINES)):
        if found := pattern.fullmatch(name):
            count = 6 if found[1] == "65" else int(found[1])
            return ElementType(kinds[count], count)
    return ElementType("", 0) if _LISTED.fullmatch(name) else None


def is_side(name: str) -> bool:
    """Return whether elements of a type are the sides of solids, as meshers write them."""
    return _SIDE.match(name) is not None


# They change nodes, elements or sets in ways that the reader does not follow.
UNSUPPORTED = frozenset(
    (
        *("ADAPTIVEMESHREFINEMENT", "ADJUST", "DISPLAYBODY", "ELCOPY", "IMPERFECTION", "IMPORT"),
        *("IMPORTELSET", "IMPORTNSET", "NCOPY", "NFILL", "NMAP", "REFINEMESH"),
        "SYMMETRICMODELGENERATION",
    )
)

# They connect nodes, of which the mesh alone knows nothing.
CONNECTIONS = frozenset(
    (
        *("COUPLING", "DISTRIBUTINGCOUPLING", "EMBEDDEDELEMENT", "EQUATION", "FASTENER"),
        *("KINEMATICCOUPLING", "MPC", "RIGIDBODY", "SHELLTOSOLIDCOUPLING", "TIE"),
    )
)

# Beginnings of the names of all others that Abaqus and CalculiX have: materials, sections,
# interactions, loads, steps, output. Surfaces are no groups here.
_HARMLESS = """
    ACOUSTIC ACTIVATE ADAPTIVEMESH AMPLITUDE ANISOTROPIC ANNEAL AQUA BASE BEAM BIAXIAL
    BLOCKAGE BOND BOUNDARY BRITTLE BUCKL BULKVISC C-ADDED CALIBRATION CAP CASTIRON CAVITY
    CECHARGE CECURRENT CENTROID CFD CFILM CFLOW CFLUX CHANGE CLAY CLEARANCE CLOAD COHESIVE
    COMBINEDTEST COMPLEXFREQ COMPOSITE CONCENTRATION CONCRETE CONDUCTIVITY CONFLUENCE CONNECTOR
    CONSTITUENT CONSTRAINT CONTACT CONTROLS CORRELATION CORRESPONDENCE COUPL CRACK CREEP CRUSH
    CYCL D-ADDED DAMAGE DAMPING DASHPOT DEBOND DECHARGE DECURRENT DEFORMATION DENSITY DEPVAR
    DESIGN DETONATION DFLOW DFLUX DIAGNOSTICS DIELECTRIC DIFFUSIVITY DIRECTCYCLIC DISCRETE
    DISTRIBUT DLOAD DRAG DRUCKER DSA DSECHARGE DSECURRENT DSFLOW DSFLUX DSLOAD DYNAMIC ELASTIC
    ELCURRENT ELECTR ELEMENTMATRIX ELEMENTOPERATOR ELEMENTOUTPUT ELEMENTPRO ELEMENTRE
    ELEMENTSOLUTION ELFILE ELPRINT EMBEDDED EMISSIVITY ENDLOADCASE ENDSTEP ENERGY ENRICHMENT EOS
    EPJOINT EQUATION EULERIAN EVENTSERIES EXPANSION EXPLICIT EXTERNALFIELD EXTREME FABRIC
    FACEPRINT FAILURE FASTENER FEASIBLE FIELD FILEFORMAT FILEOUTPUT FILM FILTER FIXEDMASS
    FLEXIBLE FLOW FLUID FOUNDATION FRACTURE FRAME FREQUENCY FRICTION GAP GAS GEL GEOMETRIC
    GEOSTATIC GLOBALDAMPING GREEN HCF HEADING HEAT HOURGLASS HYDROSTATIC HYPER HYSTERESIS
    IMPEDANCE IMPERMEABLE IMPORTCONTROLS INCIDENTWAVE INCREMENTATION INELASTIC INERTIARELIEF
    INITIAL INTEGRATEDOUTPUT INTERFACE ITSDAMPING JOINT JOULE KAPPA KINEMATIC LATENT LEADTIME
    LOAD LOWDENSITY M1 M2 MAGNETIC MAPSOLUTION MASS MATERIAL MATRI MEANFIELD MEDIA MEMBRANE
    MODAL MODELCHANGE MOHR MOISTURE MOLECULAR MONITOR MOTION MPC MULLINS NETWORK NOANALYSIS
    NOCOMPRESSION NODAL NODEFILE NODEOUTPUT NODEPRINT NODERESPONSE NONLINEAR NONSTRUCTURAL
    NORMAL NOTENSION OBJECTIVE ORIENTATION ORNL OUTPUT PARAMETER PARTICLE PERIODIC PERMANENT
    PERMEABILITY PHYSICAL PIEZO PIPE-SOIL PLANARTEST PLASTIC POREFLUID POROUS POSTOUTPUT
    POTENTIAL PRE-TENSION PREPRINT PRESSURE PRESTRESS PRINT PROBABILITY PROPERTY PSD RADIAT
    RANDOM RATEDEPENDENT RATIOS REBAR REFLECTION RELEASE RESPONSE RESTART RETAINED RIGID ROBUST
    ROTARY SECTION SELECT SENSITIVITY SFILM SFLOW SHEAR SHELL SIMPEDANCE SIMPLESHEAR SLIDELINE
    SLOADING SOILS SOLID SOLUBILITY SOLUTION SOLVER SORPTION SPECIFIC SPECTRUM SPRING SRADIATE
    STATIC STEADYSTATE STEP SUBCYCLING SUBMODEL SUBSTRUCTURE SURFACE SWELLING TABLE TEMPERATURE
    TENSILE TENSION THERMAL THICKNESS TIE TIMEPOINTS TORQUE TRACER TRANSFORM TRANSPORT
    TRANSVERSE TRIAXIAL TRS UEL UNCOUPLED UNDEX UNIAXIAL UNLOADING USER VALUES VARIABLEMASS
    VIEWFACTOR VISCO VOID VOLUMETRIC WAVE WIND XFEM
"""
_HARMLESS_NAME = re.compile("|".join(_HARMLESS.split()))


def harmless(keyword: str) -> bool:
    """Return whether a keyword says nothing of nodes, elements and sets."""
    return keyword not in UNSUPPORTED and _HARMLESS_NAME.match(keyword) is not None
