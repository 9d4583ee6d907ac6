"""What goes wrong, and what a person should know."""

from __future__ import annotations

import importlib
from typing import Any


class WillisError(ValueError):
    """What is wrong with an input or an option.

    Attributes
    ----------
    file : str or None
        The file.
    line : int or None
        The line in it, counted from 1.
    item : str or None
        What in the file, or which option.
    value : str or None
        What was found there.
    expected : str or None
        What is accepted instead.
    """

    def __init__(
        self,
        message: str,
        *,
        file: object = None,
        line: int | None = None,
        item: str | None = None,
        value: str | None = None,
        expected: str | None = None,
    ) -> None:
        super().__init__(message)
        self.file = None if file is None else str(file)
        self.line, self.item, self.value, self.expected = line, item, value, expected

    def __reduce__(self) -> tuple[object, ...]:
        fields = ("file", "line", "item", "value", "expected")
        return (_made, (str(self), {name: getattr(self, name) for name in fields}))


def _made(message: str, fields: dict[str, object]) -> WillisError:
    return WillisError(message, **fields)  # type: ignore[arg-type]


class Note(UserWarning):
    """What the command says as a note: something that a person should know."""


def library(module: str, extra: str) -> Any:
    """A module of a library that willis needs for this alone; an error that says how to install it."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        name = module.partition(".")[0]
        raise ImportError(f"{name} is not installed; pip install 'willis[{extra}]'", name=name) from error
