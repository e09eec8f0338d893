"""Modules that are left out while a package is imported, and names that are imported with their first use."""

from __future__ import annotations

import sys
import threading
from importlib import import_module
from pathlib import Path

import pytest

from mapper.core.lazy_imports import hidden_modules

ROOT = Path(__file__).parents[3]


def test_hidden_modules_are_hidden_from_this_thread_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package = tmp_path / "left_out_package"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "part.py").write_text("NUMBER = 3\n")
    monkeypatch.syspath_prepend(tmp_path)
    found = []
    try:
        with hidden_modules("left_out_package"):
            with pytest.raises(ModuleNotFoundError, match="left_out_package is left out here"):
                import_module("left_out_package.part")
            other = threading.Thread(target=lambda: found.append(import_module("left_out_package.part").NUMBER))
            other.start()
            other.join()
            assert import_module("left_out_package.part").NUMBER == 3  # loaded already
        assert found == [3]
    finally:
        for name in ("left_out_package", "left_out_package.part"):
            sys.modules.pop(name, None)


LATER = sorted(
    path.parent.relative_to(ROOT).as_posix().replace("/", ".")
    for path in (*ROOT.glob("mapper/**/__init__.py"), *ROOT.glob("server/**/__init__.py"))
    if "imported_later(__name__" in path.read_text()
)


@pytest.mark.parametrize("name", LATER)
def test_a_package_has_each_of_its_names_and_no_other(name: str) -> None:
    package = import_module(name)
    folder = Path(str(package.__file__)).parent
    for public in package.__all__:
        assert getattr(package, public) is not None
        # The import of such a module would put it in the place of what the package offers.
        assert not (folder / public).exists()
        assert not (folder / f"{public}.py").exists()
    with pytest.raises(AttributeError, match=f"module '{name}' has no attribute 'of_no_module'"):
        _ = package.of_no_module
