# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
from typing import Any, Optional

class Volute:
    codec_id: str
    max_error: Optional[float]
    rms: Optional[float]
    quality: Optional[str]
    effort: int
    def __init__(self, max_error: Optional[float] = ..., rms: Optional[float] = ..., quality: Optional[str] = ..., effort: int = ...) -> None: ...
    def encode(self, buf: Any) -> bytes: ...
    def decode(self, buf: Any, out: Any = ...) -> Any: ...
