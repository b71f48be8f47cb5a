"""Files of data loggers: their dialects are read, and what is wrong is said with its line."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rows import each

import aoimpact as ao
from aoimpact import testrig

COMMA = {"decimal": ","}
TIMES, FORCES = [0.0, 1e-4, 2e-4], [0.0, 1500.0, 300.0]


@each(
    "text, given",
    [
        ("0,0\n0.0001,1500\n0.0002,300\n", {}),
        ("t [s],force [N]\n0,0\n1e-4,1.5e3\n2e-4,300\n", {"values": "force", "time": "t"}),
        (
            "time (ms);x;load (kN)\n0,0;9;0,0\n0,1;9;1,5\n0,2;9;0,3\n",
            COMMA | {"values": "load (kN)"},
        ),
        ("# rig 7\n# t F\n0 0\n0.1 1.5\n0.2 0.3\n", {"time_unit": "ms", "unit": "kN"}),
        ('"Time"\t"Load"\n0\t0\t\n0.1\t1500\t\n0.2\t300\t\n', {"time_unit": "ms"}),
        ('t,F\n"0,0000","0"\n"0,0001","1500,0"\n"0,0002","300"\n', COMMA),
        ("t,F,x\n0,0,0\n100,+1500,0\n200,300.,0\n", {"time_unit": "us"}),
        ("t;F\n0,0;0,0\n0,1;1500,0\n0,2;300\n", COMMA | {"time_unit": "ms"}),
        ("t;F\n0,0;0,0\n100;1500\n200;300\n", COMMA | {"time_unit": "us"}),
        ("0 0\n0,1 1500,0\n0,2 300,0\n", COMMA | {"time_unit": "ms"}),
        (
            "date;t;F\n01.02.2026;0;0\n01.02.2026;1e-4;1500\n01.02.2026;2e-4;300\n",
            {"time": 1} | {"values": 2},
        ),
        ("t;F;status\n0;0;OK\n1e-4;1500;\n2e-4;300;too high, 1,2\n", {}),
        ("t;;F\n0;;0\n1e-4;;1500\n2e-4;;300\n", {"values": "F"}),
        ("Points,3,,0,0.0\nStep,1e-4,s,1e-4,1500\n,,,2e-4,300\n", {"time": 3, "values": 4}),
        ("\ufeffDate 2026-11-22, 10:00\n\nt,F\n0,0\n100,1500\n200,300\n", {"time_unit": "us"}),
    ],
)
def test_dialects(tmp_path: Path, text: str, given: dict[str, Any]) -> None:
    if "load (kN)" in text:
        given = given | {"time_unit": "ms", "unit": "kN"}
    (tmp_path / "drop.csv").write_text(text, encoding="utf-8")
    signal = testrig.read_signal(tmp_path / "drop.csv", **given)
    np.testing.assert_allclose(signal.t, TIMES, rtol=1e-12)
    np.testing.assert_allclose(signal.values, FORCES, rtol=1e-12)
    assert signal.unit == "N"


@each(
    "unit, factor, base",
    [
        ("kN", 1e3, "N"),
        ("mN", 1e-3, "N"),
        ("lbf", 4.4482216152605, "N"),
        ("g", 9.80665, "m/s²"),
        ("m/s2", 1.0, "m/s²"),
        ("km/s^2", 1e3, "m/s²"),
        ("mm", 1e-3, "m"),
        ("mV", 1e-3, "V"),
    ],
)
def test_units(tmp_path: Path, unit: str, factor: float, base: str) -> None:
    (tmp_path / "a.csv").write_text("0,1\n1,2\n")
    signal = testrig.read_signal(tmp_path / "a.csv", unit=unit, name="channel")
    np.testing.assert_allclose(signal.values, [factor, 2.0 * factor])
    assert (signal.unit, signal.name) == (base, "channel")


@each("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "latin-1"])
@each("end", ["\n", "\r\n", "\r"])
def test_encodings(tmp_path: Path, encoding: str, end: str) -> None:
    """Excel's Unicode text is UTF-16 with a mark; without one it is binary to others."""
    content = end.join(["t [µs]\tF", "0\t0", "100\t1500", "200\t300"]).encode(encoding)
    (tmp_path / "drop.txt").write_bytes(content)
    if encoding == "utf-16-le":
        with pytest.raises(ao.InputError):
            testrig.read_signal(tmp_path / "drop.txt")
        return
    signal = testrig.read_signal(tmp_path / "drop.txt", time="t", time_unit="µs")
    np.testing.assert_allclose(signal.values, FORCES)


def test_what_the_package_writes_is_read_back(tmp_path: Path) -> None:
    ball = ao.rigid(mass=0.03)
    hit = ao.simulate(projectile=ball, target=ball, law=ao.Hertz(k=1e10), velocity=1.0)
    hit.to_csv(tmp_path / "hit.csv")
    signal = testrig.read_signal(tmp_path / "hit.csv", values="force")
    np.testing.assert_array_equal(signal.t, hit.t)
    np.testing.assert_array_equal(signal.values, hit.force)


@each(
    "text, given, words",
    [
        ("t,F\n0,0\n1,x\n", {}, r"line 3\b"),
        ("t,F\n0,0\n1,1,1\n", {}, r"line 3\b"),
        ("t,F\n0,950\n1,1,500\n", {}, r"line 3\b"),
        ("t,F\n0,1,500\n1,2,590\n", {}, r"line 2\b"),
        ("t;F\n1;1,500\n2;2,590\n", {}, "decimal"),
        ("t;F\n1;1.500\n2;2.590\n", COMMA, "decimal"),
        ("t;F\n0;1e999\n1;1\n", {}, "finite"),
        ("t;F\n0;1\n1;nan\n", {}, r"line 3\b"),
        ("t;F;F\n0;1;2\n1;2;3\n", {"values": "F"}, "values"),
        ("\0\1;\2", {}, "binary"),
        ("t,F\n0,0\n1,1\n1,2\n", {}, r"line 4\b"),
        ("t,F\n", {}, "values"),
        ("", {}, "values"),
        ('0,"1\n' + 150_000 * "1", {}, "line"),
    ],
)
def test_what_is_wrong_is_said(
    tmp_path: Path, text: str, given: dict[str, Any], words: str
) -> None:
    (tmp_path / "drop.csv").write_text(text)
    with pytest.raises(ao.AOImpactError, match=words):
        testrig.read_signal(tmp_path / "drop.csv", **given)


def test_a_file_that_is_not_there_is_said(tmp_path: Path) -> None:
    with pytest.raises(ao.InputError, match=r"no\.csv"):
        testrig.read_signal(tmp_path / "no.csv")
