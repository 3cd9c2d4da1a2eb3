"""The page's own files, read once at start: nothing else can be asked for, whatever the path says."""

from __future__ import annotations

import base64
import gzip
import hashlib
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Dict

from aiohttp import web

TYPES = {
    ".html": "text/html",
    ".css": "text/css",
    ".js": "text/javascript",
    ".svg": "image/svg+xml",
}
"""Files of other kinds (licences) are not served."""
PAGE = "index.html"
INLINE = re.compile(r"<script type=\"importmap\">(.*?)</script>", re.S)


@dataclass(frozen=True)
class _File:
    kind: str
    packed: bytes
    tag: str


class Files:
    """The static page. Its policy lets it load and call nothing but this server."""

    def __init__(self, root: Path) -> None:
        """Read every file.

        Args:
            root: folder with ``index.html``.

        Raises:
            OSError: it cannot be read.
        """
        self._files: Dict[str, _File] = {}
        for path in sorted(root.rglob("*")):
            if path.suffix in TYPES:
                data = path.read_bytes()
                tag = hashlib.sha256(data).hexdigest()[:16]
                name = path.relative_to(root).as_posix()
                self._files[name] = _File(TYPES[path.suffix], gzip.compress(data, mtime=0), f'"{tag}"')
        page = (root / PAGE).read_text(encoding="utf-8")
        digests = (hashlib.sha256(script.encode()).digest() for script in INLINE.findall(page))
        inline = " ".join(f"'sha256-{base64.b64encode(digest).decode()}'" for digest in digests)
        self.headers = {
            "Content-Security-Policy": f"default-src 'none'; script-src 'self' {inline}; style-src 'self'; "
            "img-src 'self' data:; connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
            "X-Content-Type-Options": "nosniff",
            "X-Frame-Options": "DENY",
            "Referrer-Policy": "no-referrer",
            "Cross-Origin-Resource-Policy": "same-origin",
            "Cache-Control": "no-cache",
        }

    async def get(self, request: web.Request) -> web.StreamResponse:
        """Handler of every path that is no other's."""
        file = self._files.get(request.path.lstrip("/") or PAGE)
        if file is None:
            return web.json_response({"success": False, "message": "there is no such file"}, status=404)
        if request.headers.get("If-None-Match") == file.tag:
            return web.Response(status=304, headers={**self.headers, "ETag": file.tag})
        headers = {**self.headers, "ETag": file.tag, "Vary": "Accept-Encoding"}
        body = file.packed
        if "gzip" in request.headers.get("Accept-Encoding", ""):
            headers["Content-Encoding"] = "gzip"
        else:
            body = gzip.decompress(body)
        return web.Response(body=body, content_type=file.kind, charset="utf-8", headers=headers)
