# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
from typing import Any

class Backend:
    def open_dataset(self, filename_or_obj: Any, *, drop_variables: Any = ..., partial: bool = ..., max_memory: int = ...) -> Any: ...
    def guess_can_open(self, filename_or_obj: Any) -> bool: ...
