"""The fault report is current, every row has tests or states what is missing, and every claim belongs to a row."""

from __future__ import annotations

from typing import Any

import pytest

from tests.house.support import load

report = load("scripts/fault_report.py")


def test_the_report_is_current_and_every_row_is_proven_or_says_what_lacks() -> None:
    table, proofs = report.rows(), report.proofs()
    assert len(proofs) > 100
    assert report.faults(table, proofs) == []
    assert report.REPORT.read_text(encoding="utf-8") == report.render(table, proofs), "make faults"


ROW: dict[str, Any] = {"fault": "a fault", "bar": "a bar", "state": "proven"}


def table(**change: Any) -> list[dict[str, Any]]:
    """Return all rows as proven, with changes to the seventh."""
    rows = [{"number": number, **ROW} for number in report.NUMBERS]
    rows[6] |= change
    return [{key: value for key, value in row.items() if value is not None} for row in rows]


def proofs(*without: int) -> list[Any]:
    return [report.Proof(number, "a.rs", "a_test", "0 of 5", "") for number in report.NUMBERS if number not in without]


@pytest.mark.parametrize(
    ("change", "without", "says"),
    [
        ({}, (7,), "row 7 is proven, and 0 tests name it"),
        ({"state": "absent", "lacks": "no test"}, (), "row 7 is absent, and 1 tests name it"),
        ({"state": "partly"}, (), "what lacks is said"),
        ({"lacks": "a plane"}, (), "what lacks is said"),
        ({"state": "nearly", "lacks": "a plane"}, (), "one of the states"),
        ({"number": 6}, (), "each once"),
        ({"long_result": "well"}, (), "which long form"),
        ({"bar": ""}, (), "fault, bar"),
    ],
)
def test_a_claim_without_proof_is_found(change: dict[str, Any], without: tuple[int, ...], says: str) -> None:
    assert report.faults(table(), proofs()) == []
    assert any(says in fault for fault in report.faults(table(**change), proofs(*without)))


def test_a_proof_of_no_row_is_found() -> None:
    stray = report.Proof(65, "a.rs", "a_test", "0 of 5", "")
    assert report.faults(table(), [*proofs(), stray]) == ["a.rs: a_test: there is no row 65"]


def test_markers_are_read_where_they_stand() -> None:
    rust = "    // fault 32 (500 seeds): 0 of 500 contaminated\n    // fault 17: blocked\n    #[test]\n    fn uploads() {\n"
    found = list(report.in_comments("a.rs", rust))
    assert [(one.row, one.test, one.seeds) for one in found] == [(32, "uploads", "500"), (17, "uploads", "")]
    script = "// fault 12: 3.5 s\n  it('tells what is stale', () => {"
    assert [one.test for one in report.in_comments("a.ts", script)] == ["tells what is stale"]
    python = "@pytest.mark.fault(3, figure='told', seeds=2)\n@other\nasync def test_it(): ...\n"
    assert list(report.in_python("a.py", python)) == [report.Proof(3, "a.py", "test_it", "told", "2")]
    with pytest.raises(report.MarkerFault):
        list(report.in_comments("a.rs", "// fault 1: told\nlet it = 3;\n"))
    with pytest.raises(report.MarkerFault):
        list(report.in_python("a.py", "@pytest.mark.fault(3)\ndef test_it(): ...\n"))
