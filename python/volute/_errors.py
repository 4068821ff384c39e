# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Exceptions of Volute, which are also of the corresponding Python types."""
import contextlib
import errno
import os


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


class NotFound(Error, FileNotFoundError):
    """A file, a grid or a name does not exist. `filename` and `errno` are those of a missing file; None where something in a file is missing."""
    code = "not-found"

    def __setattr__(self, name, value):
        super().__setattr__(name, value)
        if name in ("path", "member"):
            missing = self.path and not self.member and not os.path.exists(self.path)
            self.filename, self.errno = (self.path, errno.ENOENT) if missing else (None, None)


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


class IoError(Error, OSError):
    """The system refused to read or write. `errno` is None: why is in the message."""
    code = "io"

    def __setattr__(self, name, value):
        super().__setattr__(name, value)
        if name == "path":
            self.filename = value


class Cancelled(Error):
    """The call was cancelled."""
    code = "cancelled"
