"""The licences in the bill of materials."""

import json
from importlib import metadata
from pathlib import Path

from adcs import bill
from fmus.paths import EIGEN


class Package(metadata.Distribution):
    """A package with this metadata, and one licence file."""

    def __init__(self, about: str) -> None:
        self._about = about

    def read_text(self, filename: str) -> str | None:
        return {
            "METADATA": f"Metadata-Version: 2.4\nName: theirs\nVersion: 1.0\n{self._about}\n",
            "RECORD": "theirs-1.0.dist-info/licenses/LICENSE.txt,,\n",
        }.get(filename)

    def locate_file(self, path):
        folder = Path(__file__).parent
        return folder / "conftest.py" if str(path).endswith("LICENSE.txt") else folder / path


def test_of_what_is_installed() -> None:
    assert bill.licences(metadata.distribution("cmeel-eigen")) == [
        {"expression": "Apache-2.0 AND MPL-2.0", "acknowledgement": "concluded"}
    ]
    assert bill.licences(metadata.distribution("h5py")) == [
        {"expression": "BSD-3-Clause", "acknowledgement": "declared"}
    ]
    (fmpy,) = bill.licences(metadata.distribution("fmpy"))  # which has nothing but the file
    assert fmpy["license"]["name"] == "LICENSE.txt"
    assert "2-Clause BSD license" in fmpy["license"]["text"]["content"]


def test_the_headers_of_eigen_say_what_is_said_of_them() -> None:
    for header in ("Core/Matrix.h", "Core/products/GeneralMatrixMatrix.h", "Geometry/Quaternion.h"):
        top = " ".join((EIGEN / "Eigen" / "src" / header).read_text(encoding="utf-8")[:900].split())
        assert "subject to the terms of the Mozilla // Public License v. 2.0" in top


def test_where_metadata_say_it() -> None:
    classes = Package("License: see below\nClassifier: License :: OSI Approved :: MIT License\nClassifier: Topic :: X")
    assert bill.licences(classes) == [{"license": {"name": "MIT License", "acknowledgement": "declared"}}]
    field = Package("License: Apache License 2.0")
    assert bill.licences(field) == [{"license": {"name": "Apache License 2.0", "acknowledgement": "declared"}}]
    (text,) = bill.licences(Package(f"License: {'all of the text ' * 20}\nLicense-File: LICENSE.txt"))
    assert text["license"]["text"]["content"] == (Path(__file__).parent / "conftest.py").read_text()
    assert bill.licences(Package("")) == []


def test_a_bill_is_completed_and_keeps_what_it_has(tmp_path: Path) -> None:
    file = tmp_path / "bill.json"
    ours = {"bom-ref": "1", "name": "cmeel-eigen", "version": "3.4.1"}
    other = {"bom-ref": "2", "name": "no-such-package-here", "version": "1"}
    file.write_text(json.dumps({"components": [ours, other], "specVersion": "1.6"}))
    bill.main(file)
    once = file.read_bytes()
    expected = [{"expression": "Apache-2.0 AND MPL-2.0", "acknowledgement": "concluded"}]
    assert json.loads(once) == {"components": [{**ours, "licenses": expected}, other], "specVersion": "1.6"}
    bill.main(file)
    assert file.read_bytes() == once
