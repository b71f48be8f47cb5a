"""Files that Nastran itself has written: some of pyYeti's, and, where it is installed, all."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import aoimpact as ao
from aoimpact.io import load_matrices

SAMPLES = Path(__file__).parent / "samples"


def test_nastran_s_superelement_is_free() -> None:
    """Its interface and modal coordinates have six motions without force, and no more."""
    body = ao.read_matrices(SAMPLES / "outboard.op4")
    assert body.n_dofs == 46
    assert body.rigid_modes.shape == (46, 6)


def pyyeti_files() -> list[Path]:
    try:
        with np.printoptions():
            import pyyeti
    except ImportError:
        return []
    return sorted((Path(pyyeti.__file__).parent / "tests").glob("*/*.op4"))


# Of a file whose matrix has no proper name.
@pytest.mark.filterwarnings("ignore:Output4 file has matrix name:RuntimeWarning")
@pytest.mark.parametrize(
    "file", pyyeti_files() or [None], ids=lambda file: getattr(file, "stem", "")
)
def test_all_of_pyyeti_s_files_are_read_as_it_reads_them(file: Path | None) -> None:
    if file is None:
        pytest.skip("pyyeti is not installed")
    with np.printoptions():  # it changes how arrays are printed
        from pyyeti.nastran import op4

    names, theirs, _, _ = op4.OP4().listload(str(file), sparse=True)
    ours = load_matrices(file)
    assert len(names) == len(ours)
    for name, one, matrix in zip(names, ours, theirs, strict=True):
        if one.name.isidentifier():
            assert name == one.name.lower()
        square = matrix.shape[0] == matrix.shape[1]
        assert bool(one.unfit) == (not square or np.iscomplexobj(matrix))
        if not one.unfit and one.matrix.shape[0] < 10_000:
            np.testing.assert_array_equal(one.matrix.toarray(), matrix.toarray())


def test_pyyeti_s_punched_matrices_are_read_as_it_reads_them() -> None:
    pyyeti = pytest.importorskip("pyyeti")
    from pyyeti.nastran import bulk

    file = Path(pyyeti.__file__).parent / "tests" / "nastran_dmig_data" / "matrix_factory.pch"
    theirs = bulk.rddmig(str(file))
    ours = {one.name.lower(): one for one in load_matrices(file)}
    assert ours.keys() == theirs.keys()
    for name in ("patrn", "ident", "randm"):
        assert ours[name].labels is not None
        assert [tuple(label) for label in ours[name].labels] == theirs[name].index.to_list()
        np.testing.assert_array_equal(ours[name].matrix.toarray(), theirs[name].to_numpy())
    assert ours["cmplx"].unfit == "complex"
