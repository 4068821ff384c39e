# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""What Volute raises: its own sentences, as exceptions that are also those of Python that say the same."""


class Error(Exception):
    """Any error of Volute. Its text says what is wrong, where, what was expected, and what to do."""


class InvalidArgument(Error, ValueError):
    """A value that was given makes no sense."""


class NotFound(Error, FileNotFoundError):
    """A file, a grid or a name is not there."""


class InvalidData(Error, ValueError):
    """A file says something impossible or fails its checksum."""


class Truncated(InvalidData, EOFError):
    """A file ends before its data do."""


class Unsupported(Error, NotImplementedError):
    """Valid, but a part or version that this build does not know."""


class TooLarge(Error, MemoryError):
    """Does not fit in the memory that was allowed (`max_memory`)."""


class IoError(Error, OSError):
    """The system refused to read or write."""


class Cancelled(Error):
    """Somebody asked to stop."""
