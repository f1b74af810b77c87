"""Filters of VTK run from Python: their errors are exceptions, their warnings are Python's."""

from __future__ import annotations

import warnings

from vtkmodules.util.misc import calldata_type
from vtkmodules.vtkCommonCore import VTK_STRING, vtkObject


class Error(RuntimeError):
    """What TreeAMR reports of its input: the object, what was found and what is allowed."""


def _message(text: str) -> str:
    """Without VTK's lines of class, file and address."""
    lines = [line.strip() for line in text.strip().splitlines()]
    if lines and lines[0].startswith(("ERROR: In ", "Warning: In ")):
        lines = lines[1:]
    text = " ".join(lines)
    return text.partition("): ")[2] or text


class Messages:
    """Collects what objects report: `with Messages(filter): filter.Update()` raises Error or warns at its end."""

    def __init__(self, *objects: vtkObject):
        self._errors: list[str] = []
        self._warnings: list[str] = []
        self._objects = objects
        self.failed: vtkObject | None = None  # whether it says so or not: Python loses texts that are no UTF-8

    def __enter__(self) -> Messages:
        @calldata_type(VTK_STRING)
        def on_error(_object, _event, text):
            self._errors.append(_message(text))

        @calldata_type(VTK_STRING)
        def on_warning(_object, _event, text):
            self._warnings.append(_message(text))

        self._tags = [(o, o.AddObserver(event, call)) for o in self._objects
                      for event, call in (("ErrorEvent", on_error), ("WarningEvent", on_warning))]
        return self

    def __exit__(self, kind, _value, _traceback) -> None:
        for o, tag in self._tags:
            o.RemoveObserver(tag)
        for text in self._warnings:
            warnings.warn(text, stacklevel=4)
        if self._errors and kind is None:
            # What the executive adds is that an algorithm has failed, with all of its request.
            told = [text for text in self._errors if " returned failure for request" not in text]
            raise Error("; ".join(told or self._errors))
        if self.failed and kind is None:
            raise Error(f"{self.failed.GetClassName()} failed without a word")


def output(algorithm):
    """The data set that an algorithm makes. Raises Error."""
    with Messages(algorithm, algorithm.GetExecutive()) as messages:
        if not algorithm.GetExecutive().Update(0):
            messages.failed = algorithm
    return algorithm.GetOutputDataObject(0)
