# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Exceptions of Volute, which are also of the corresponding Python types."""


class Error(Exception):
    """Any error of Volute. The message says what is wrong, where, what was expected, and what to do."""


class InvalidArgument(Error, ValueError):
    """An argument is invalid."""


class NotFound(Error, FileNotFoundError):
    """A file, a grid or a name does not exist."""


class InvalidData(Error, ValueError):
    """A file is inconsistent or fails its checksum."""


class Truncated(InvalidData, EOFError):
    """A file ends before its data do."""


class Unsupported(Error, NotImplementedError):
    """Valid, but unknown to this build."""


class TooLarge(Error, MemoryError):
    """Does not fit in the allowed memory (`max_memory`)."""


class IoError(Error, OSError):
    """The system refused to read or write."""


class Cancelled(Error):
    """The call was cancelled."""
