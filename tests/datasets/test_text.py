"""What stands in the cells of a table: quotes, line breaks and marks."""

from robot_perception import datasets
from robot_perception.datasets import (
    read_columns,
    read_track,
)


def test_names_may_be_parted_by_other_marks_than_numbers(tmp_path):
    """As numpy.savetxt writes a header and rows."""
    (tmp_path / "a.csv").write_text("# time_s,x_m,y_m,heading_rad\n0 1 2 3\n1 1 2 3\n")
    assert read_track(tmp_path / "a.csv").poses.tolist() == [[1, 2, 3]] * 2


def test_a_last_cell_may_be_empty_in_a_column_that_is_left_out(tmp_path):
    (tmp_path / "a.csv").write_text("#time_s,id,note\n0,1,\n1,2,hi\n")
    assert read_columns(tmp_path / "a.csv", {"time_s": 9, "id": 9})["id"].tolist() == [1, 2]


def test_texts_keep_what_stands_in_quotes(tmp_path):
    text = 'time_s,note\n0,"left, then ""right"""\n\n1,"two\n# lines\n\nand more"\n2,5" wide\n'
    (tmp_path / "a.csv").write_text(text)
    notes = read_columns(tmp_path / "a.csv", {"time_s": 9}, texts=["note"])["note"]
    assert notes.tolist() == ['left, then "right"', "two\n# lines\n\nand more", '5" wide']


def test_names_may_hold_what_parts_cells(tmp_path):
    (tmp_path / "a.csv").write_text('"a;b","c\td",x\n1,2,3\n')
    limits = {"a;b": 9, "c\td": 9, "x": 9}
    found = read_columns(tmp_path / "a.csv", limits)
    assert {name: column.tolist() for name, column in found.items()} == dict(
        zip(limits, [[1], [2], [3]], strict=True)
    )


def test_every_line_of_a_quoted_text_is_counted(tmp_path):
    (tmp_path / "a.txt").write_text('1 2 0 0 0 0 0 "0\n"\n1 3 0 0 0 0 0 0\n')
    report = datasets.read_relations(tmp_path / "a.txt").report
    assert (report.kept, report.others) == ({"relation": 2}, {"continued": 1})
    assert report.lines == 3
