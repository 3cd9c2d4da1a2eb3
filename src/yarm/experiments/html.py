"""Pieces of result pages: one file each, readable offline, nothing fetched from anywhere."""

from __future__ import annotations

import html
import math
from pathlib import Path
from typing import Sequence

STYLE = """
body{font:14px/1.45 sans-serif;max-width:1180px;margin:1.5em auto;padding:0 1em;color:#222}
section{border-top:2px solid #888;padding:.6em 0 1.2em;page-break-inside:avoid}
h2{margin:.2em 0}.right{color:#17722b}.wrong{color:#b3261e}
.row{display:flex;gap:1em;flex-wrap:wrap;align-items:flex-start}
figure{margin:0}figcaption{color:#555;font-size:12px}
table{border-collapse:collapse}td,th{padding:1px 8px;text-align:left;font-size:12px;vertical-align:top}
td.bar{width:180px}td.bar div{background:#4a7fb5;height:9px;min-width:1px}
tr:nth-child(even){background:#f3f3f3}
code{font-size:12px;overflow-wrap:anywhere}
"""
Rows = Sequence[Sequence[str]]


def write_page(path: Path, title: str, body: Sequence[str]) -> Path:
    """Write a page of parts that are HTML already; the title is text. Gives back the path."""
    parts = ["<!DOCTYPE html>", '<html lang="en">', f"<head><meta charset='utf-8'><title>{html.escape(title)}</title>"]
    parts += ["<meta name='viewport' content='width=device-width'>"]
    parts += [f"<style>{STYLE}</style></head><body>", f"<h1>{html.escape(title)}</h1>"]
    path.write_text("\n".join([*parts, *body, "</body></html>"]) + "\n", encoding="utf-8")
    return path


def table(header: Sequence[str], rows: Rows, name: str = "") -> str:
    """A table of texts; with a name it can be found by its id."""
    head = "".join(f"<th>{html.escape(cell)}</th>" for cell in header) if any(header) else ""
    body = "".join("<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    own = f" id='{html.escape(name, quote=True)}'" if name else ""
    return f"<table{own}>{f'<tr>{head}</tr>' if head else ''}{body}</table>"


def figure(picture: str, caption: str) -> str:
    """A picture that is HTML already, with a caption of text."""
    return f"<figure>{picture}<figcaption>{html.escape(caption)}</figcaption></figure>"


def folded(summary: str, content: str) -> str:
    """Content that is HTML already, shown on demand under a line of text."""
    return f"<details><summary>{html.escape(summary)}</summary>{content}</details>"


def number(value: float, digits: int, unit: str = "") -> str:
    """A number with its unit; a dash for one that is not finite."""
    return f"{value:.{digits}f}{f' {unit}' if unit else ''}" if math.isfinite(value) else "-"
