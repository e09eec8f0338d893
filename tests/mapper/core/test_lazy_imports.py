"""Modules that are left out while a package is imported."""

from __future__ import annotations

import sys
import threading
from importlib import import_module
from pathlib import Path

import pytest

from mapper.core.lazy_imports import hidden_modules


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
