# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Exceptions of Volute, which are also of the corresponding Python types."""
import contextlib
import errno


class Error(Exception):
    """Any error of Volute. The message says what is wrong, where, what was expected, and what to do."""
    code = "error"  #: what kind it is, as "invalid-data"
    path = None  #: the file that it is about
    member = None  #: the place in the file, or the argument
    hint = None  #: what to do: "raise max_memory"

    def __str__(self):
        return Exception.__str__(self)  # OSError has another


class InvalidArgument(Error, ValueError):
    """An argument is invalid."""
    code = "invalid-argument"


@contextlib.contextmanager
def about(path):
    """Errors of no other file are of this one."""
    try:
        yield
    except Error as error:
        if error.path is None:
            error.path = path
        raise


class _OfSystem(Error):
    """With what OSError has."""

    def __setattr__(self, name, value):
        super().__setattr__(name, value)
        if name == "path":
            self.filename, self.errno = value, self._errno if value else None


class NotFound(_OfSystem, FileNotFoundError):
    """A file, a grid or a name does not exist."""
    code, _errno = "not-found", errno.ENOENT


class InvalidData(Error, ValueError):
    """A file is inconsistent or fails its checksum."""
    code = "invalid-data"


class Truncated(InvalidData, EOFError):
    """A file ends before its data do."""
    code = "truncated"


class Unsupported(Error, NotImplementedError):
    """Valid, but unknown to this build."""
    code = "unsupported"


class TooLarge(Error, MemoryError):
    """Does not fit in the allowed memory (`max_memory`)."""
    code = "too-large"


class IoError(_OfSystem, OSError):
    """The system refused to read or write."""
    code, _errno = "io", errno.EIO


class Cancelled(Error):
    """The call was cancelled."""
    code = "cancelled"
