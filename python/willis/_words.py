"""Options of Python as the words of the command, so that both mean the same."""

from __future__ import annotations

import operator
import os
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Union

from ._errors import WillisError

Nodes = Union[Sequence[Union[str, int]], Mapping[Any, Union[str, float]]]
"""``NODE`` or ``NODE=VALUE`` each, or values by node."""


def text(value: Any) -> str:
    """A value as it is typed."""
    if isinstance(value, (list, tuple)) or (hasattr(value, "tolist") and getattr(value, "ndim", 0) > 0):
        return ",".join(text(one) for one in value)
    value = _plain(value)
    if isinstance(value, float):
        return repr(value)
    return os.fspath(value) if isinstance(value, os.PathLike) else str(value)


def _plain(value: Any) -> Any:
    """A number of NumPy as one of Python."""
    return value.item() if hasattr(value, "item") and not getattr(value, "ndim", 0) else value


def whole(name: str, value: Any, most: int = 2**32 - 1) -> int:
    """A whole number for the compiled part, which knows its range."""
    is_whole = hasattr(value, "__index__") and not isinstance(value, bool)
    if not is_whole or not 0 <= operator.index(value) <= most:
        expected = "a whole number that is not negative" if not is_whole or operator.index(value) < 0 else f"at most {most}"
        raise WillisError(f"{name} {value!r}: expected {expected}", item=name, value=repr(value), expected=expected)
    return operator.index(value)


def words(given: dict[str, Any], defaults: dict[str, Any]) -> list[str]:
    """The options that are not at their default, in their order; a list of texts is an option for each."""
    out: list[str] = []
    for name, value in given.items():
        if value is None or (name in defaults and _same(value, defaults[name])):
            continue
        flag = ("-" if len(name) == 1 else "--") + name.replace("_", "-")
        if isinstance(plain := _plain(value), bool) != isinstance(defaults.get(name), bool):
            expected = "a value, neither True nor False" if isinstance(plain, bool) else "True or False"
            raise WillisError(f"{name} {value!r}: expected {expected}", item=name, value=repr(value), expected=expected)
        if isinstance(plain, bool):
            out.extend([flag] * plain)
        elif isinstance(value, Repeated):
            for one in value.values:
                out.extend(_pair(flag, text(one)))
        else:
            out.extend(_pair(flag, text(value)))
    return out


def conditions(inlets: Any, outlets: Any, flows: Any) -> dict[str, Any]:
    """The options of boundary conditions; ``outlets`` as one text is the rule for those that are found."""
    rule = outlets if isinstance(outlets, str) else None
    return {"inlet": Repeated(inlets), "outlet": Repeated(None if rule else outlets), "flow": Repeated(flows), "outlets": rule}


def _pair(flag: str, value: str) -> tuple[str, ...]:
    """An option and its value; in one word where the value looks like an option."""
    return (f"{flag}={value}",) if value.startswith("-") and flag.startswith("--") else (flag, value)


def _same(value: Any, default: Any) -> bool:
    try:
        return bool(value == default)
    except ValueError:
        return False


class Repeated:
    """An option that is given once for each of several values, or for the only one; values by name are ``NAME=VALUE``."""

    def __init__(self, values: Any) -> None:
        if isinstance(values, Mapping):
            values = [f"{text(name)}={text(value)}" for name, value in values.items()]
        several = isinstance(values, Iterable) and not isinstance(values, str)
        self.values = [] if values is None else list(values) if several else [values]
