# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
from typing import Any, Dict, List, Optional

import numpy.typing as npt

from . import Frames, Path

class Case(Frames):
    def __init__(self, path: Path, *, quantity: str = ..., source: str = ..., mass_extinction: float = ..., mesh: Optional[int] = ...,
                 bounds: Optional[npt.ArrayLike] = ..., max_memory: int = ...) -> None: ...
    @property
    def remarks(self) -> List[str]: ...
    @property
    def sources(self) -> Dict[str, str]: ...
    @property
    def source(self) -> str: ...

def open(path: Path, *, quantity: str = ..., source: str = ..., mass_extinction: float = ..., mesh: Optional[int] = ...,
         bounds: Optional[npt.ArrayLike] = ..., max_memory: int = ...) -> Case: ...
