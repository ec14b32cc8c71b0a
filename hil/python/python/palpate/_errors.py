"""Errors that Palpate raises."""

from __future__ import annotations


class Error(Exception):
    """Base class of every error of Palpate.

    The text is complete. The attributes hold its parts; a part that does not apply is None.

    Attributes:
        file: The file that cannot be used or written, as the caller named it; for a value set in a call, the argument.
        line: Line in the file, counted from one.
        key: Full key in the file (``touches[0].force_n.mean``), or the column.
        expected: What would have been right.
        found: What was there instead.
        hint: What to do.
    """

    def __init__(
        self,
        message: str,
        *,
        file: str | None = None,
        line: int | None = None,
        key: str | None = None,
        expected: str | None = None,
        found: str | None = None,
        hint: str | None = None,
    ) -> None:
        super().__init__(message)
        self.file = file
        self.line = line
        self.key = key
        self.expected = expected
        self.found = found
        self.hint = hint

    def __reduce__(self) -> tuple[object, ...]:
        # The default would lose the attributes on their way from a worker.
        return _remade, (type(self), str(self), self.__dict__)

    @classmethod
    def of(cls, what: str, expected: str, found: str, hint: str | None = None) -> Error:
        """An error about an argument.

        Args:
            what: The argument.
            expected: What would have been right.
            found: What was there instead.
            hint: What to do.
        """
        text = f"{what}: expected {expected}, found {found}"
        return cls(
            text if hint is None else f"{text}; {hint}",
            file=what,
            expected=expected,
            found=found,
            hint=hint,
        )


class InputError(Error, ValueError):
    """An argument or a file that cannot be used."""


class DeviceError(Error, RuntimeError):
    """A bus or a device failed, or a file could not be written."""


class GuardError(Error, RuntimeError):
    """The guard stopped the drive."""


class CheckError(Error, RuntimeError):
    """A check failed."""


class BusyError(Error, RuntimeError):
    """Another thread is inside the same object."""


class BugError(Error, RuntimeError):
    """A fault of Palpate itself: please report it with what led to it."""


def _remade(kind: type[Error], message: str, parts: dict[str, object]) -> Error:
    made = kind(message)
    made.__dict__.update(parts)
    return made
