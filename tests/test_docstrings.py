"""Examples in the docstrings of what `cohesive` offers, and that there are docstrings."""

from __future__ import annotations

import doctest
import inspect

import pytest

import cohesive

#: examples that stand here, by name
WITH_EXAMPLES = (
    "CrackPlane",
    "Scene",
    "compare",
    "fit",
    "prepare",
    "register_softening",
    "run",
    "sensitivities",
    "settings_for",
    "sweep",
)


@pytest.mark.parametrize("name", WITH_EXAMPLES)
def test_examples_of_the_docstrings_run(name: str) -> None:
    (test,) = doctest.DocTestFinder(recurse=False).find(getattr(cohesive, name), name)
    assert test.examples
    assert doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE).run(test).failed == 0


@pytest.mark.parametrize("name", cohesive.__all__)
def test_public_names_and_their_methods_are_described(name: str) -> None:
    each = getattr(cohesive, name)
    assert inspect.getdoc(each)
    for method, value in vars(each).items() if inspect.isclass(each) else ():
        if not method.startswith("_") and (inspect.isfunction(value) or isinstance(value, (property, classmethod))):
            assert inspect.getdoc(getattr(each, method)), f"{name}.{method}"
