"""Options of Python as the words of the command, so that both mean the same."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import Any


def text(value: Any) -> str:
    """A value as it is typed."""
    if isinstance(value, (list, tuple)) or (hasattr(value, "tolist") and getattr(value, "ndim", 0) > 0):
        return ",".join(text(one) for one in value)
    if hasattr(value, "item"):
        value = value.item()
    if isinstance(value, float):
        return repr(value)
    return os.fspath(value) if isinstance(value, os.PathLike) else str(value)


def words(given: dict[str, Any], defaults: dict[str, Any]) -> list[str]:
    """The options that are not at their default, in their order; a list of texts is an option for each."""
    out: list[str] = []
    for name, value in given.items():
        if value is None or (name in defaults and _same(value, defaults[name])):
            continue
        flag = ("-" if len(name) == 1 else "--") + name.replace("_", "-")
        if value is True:
            out.append(flag)
        elif value is False:
            continue
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
    """An option that is given once for each of several values, or for the only one."""

    def __init__(self, values: Any) -> None:
        several = isinstance(values, Iterable) and not isinstance(values, str)
        self.values = [] if values is None else list(values) if several else [values]
