"""Keys of a scene as fields of dataclasses: default, unit, range and meaning stand once, beside the name."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import MISSING, Field, field, fields
from numbers import Integral
from typing import Any


def key(
    meaning: str,
    default: Any = MISSING,
    *,
    unit: str = "",
    above: float | None = None,
    at_least: float | None = None,
    below: float | None = None,
    at_most: float | None = None,
    one_of: tuple[str, ...] = (),
    by_rule: bool = False,
    hash: bool | None = None,
) -> Any:
    """A field of a dataclass that is a key of a scene.

    None is always in range; a string is, if the range has numbers. A key without a default must be given, or follows from
    others by a rule. `hash` is that of `dataclasses.field`.
    """
    bounds = {"above": above, "at_least": at_least, "below": below, "at_most": at_most}
    given = {name: bound for name, bound in bounds.items() if bound is not None}
    metadata = {"meaning": meaning, "unit": unit, "bounds": given, "one_of": one_of, "by_rule": by_rule}
    return field(default=default, hash=hash, metadata=metadata)


def key_of(each: Field[Any]) -> str:
    """Name of the key that a field is: a field that would hide a method of its class has an underscore behind."""
    return each.name.removesuffix("_")


def expected(metadata: Mapping[str, Any]) -> str:
    """The range of a key in words; empty if every value of its type will do."""
    if metadata.get("one_of"):
        return " or ".join(map(repr, metadata["one_of"]))
    bounds = metadata.get("bounds", {})
    words = [f"{name.replace('_', ' ')} {bound:g}" for name, bound in bounds.items()]
    text = " and ".join(words)
    return f"of {text}" if text.startswith("at") else text


def out_of_range(instance: Any) -> Iterator[tuple[str, Any, str]]:
    """Name, value and expectation of each key that is out of its range."""
    for each in fields(instance):
        value, bounds = getattr(instance, each.name), each.metadata.get("bounds", {})
        if value is None:
            continue
        one_of = each.metadata.get("one_of", ())
        if one_of and value not in one_of:
            yield key_of(each), value, expected(each.metadata)
        is_whole = each.type not in ("int", "int | None") or isinstance(value, Integral)
        if bounds and not isinstance(value, str) and not (is_whole and _is_within(value, bounds)):
            unit = f", in {each.metadata['unit']}" if each.metadata["unit"] else ""
            yield key_of(each), value, f"a {'' if is_whole else 'whole '}number {expected(each.metadata)}{unit}"


def _is_within(value: Any, bounds: Mapping[str, float]) -> bool:
    """NaN is within no bounds."""
    holds = {
        "above": lambda bound: value > bound,
        "at_least": lambda bound: value >= bound,
        "below": lambda bound: value < bound,
        "at_most": lambda bound: value <= bound,
    }
    return all(holds[name](bound) for name, bound in bounds.items())


def check_keys(instance: Any, error: Callable[[str, str], Exception]) -> None:
    """Refuse the first key that is out of its range: an `error` made of what it says, which names key, value and range, and
    of the key."""
    for name, value, what in out_of_range(instance):
        raise error(f"{name} = {value!r}: expected {what}", name)


def default_of(each: Field[Any]) -> Any:
    """Default of a field; MISSING if a scene must give it."""
    return each.default_factory() if each.default_factory is not MISSING else each.default
