"""The table of what was measured."""

from tests.installed.table import Table


def test_a_table_says_what_was_missed():
    table = Table()
    table.add("components", 45)
    table.add("wheel", 3.58, "MB", aim=4)
    table.add("first run", 31.25, "s", aim=30)
    assert str(table).splitlines() == [
        "measured      value   aim",
        "components       45",
        "wheel       3.58 MB  4 MB  met",
        "first run    31.2 s  30 s  missed",
    ]
