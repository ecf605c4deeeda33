"""What the documents show works: the README's example, from first to last line, and the docstrings'."""

import doctest
import importlib
import pkgutil
import re
from pathlib import Path

import pytest

import taxel

README = Path(__file__).resolve().parents[1] / "README.md"


def test_the_readmes_example(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), flags=re.DOTALL)
    assert len(blocks) > 5
    names = {"__name__": "readme"}
    for at, block in enumerate(blocks):
        exec(compile(block, f"README.md, block {at + 1}", "exec"), names)
    assert (tmp_path / "hardness.safetensors").is_file()
    assert "resnet8-lite-1d" in capsys.readouterr().out


@pytest.mark.parametrize("name", [own.name for own in pkgutil.iter_modules(taxel.__path__) if own.name != "_taxel"])
def test_docstrings(name):
    found = doctest.testmod(importlib.import_module(f"taxel.{name}"), optionflags=doctest.IGNORE_EXCEPTION_DETAIL)
    assert found.failed == 0


def test_everything_public_has_a_docstring_and_a_type():
    stubs = (Path(taxel.__file__).parent / "_taxel.pyi").read_text(encoding="utf-8")
    for name in taxel.__all__:
        own = getattr(taxel, name)
        assert name == "__version__" or own.__doc__, name
    for name in dir(taxel._taxel):
        if not name.startswith("_"):
            assert re.search(rf"^(class|def) {name}\b|^{name}:", stubs, flags=re.MULTILINE), f"{name} is in no stub"
            own = getattr(taxel._taxel, name)
            for method in dir(own) if isinstance(own, type) else []:
                if not method.startswith("_"):
                    assert re.search(rf"^    def {method}\b", stubs, flags=re.MULTILINE), f"{name}.{method}"
    assert (Path(taxel.__file__).parent / "py.typed").is_file()
