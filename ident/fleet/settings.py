"""Settings of a fleet's analysis, and the digest that says whether a result is still the one they would give."""

import hashlib
import json
from dataclasses import asdict, dataclass

METHOD = 2
"""Version of the method of `recording_rows`; raised whenever the same recording gives other rows."""


@dataclass(frozen=True)
class FleetSettings:
    """How each recording is analysed."""

    preprocessing: str = "parallel"
    cutoff: float | None = None
    """[Hz]; None: chosen from the spectra."""

    @property
    def digest(self) -> str:
        """Of the settings and the method."""
        content = json.dumps({**asdict(self), "method": METHOD}, sort_keys=True)
        return hashlib.sha256(content.encode()).hexdigest()[:16]

    def key(self, content: str, failed_at: str = "") -> str:
        """Digest of a recording's `content` (SHA-256), the settings and the method: the identity of its rows.

        failed_at: path of a file that is no usable recording; each such file has a row, even if it is a copy.
        """
        return hashlib.sha256(f"{content}:{self.digest}:{failed_at}".encode()).hexdigest()
