"""The transition table drawn for the docs: the same data the Commander runs on."""

from __future__ import annotations

from typing import Dict, List, Sequence, Tuple

from yarm.commander.states import STATE_DOCS, TABLE, State, Transition


def table_markdown(table: Sequence[Transition] = TABLE) -> str:
    """The table in Markdown, one row a state and trigger."""
    lines = ["| state | name | what it does | request | leads to | what happens |", "|---|---|---|---|---|---|"]
    for state in State:
        head = f"| {int(state)} | {state.name} | {STATE_DOCS[state]} "
        for row in (row for row in table if row.source is state):
            needs = " (once it has succeeded)" if row.needs_success else ""
            lines.append(f"{head}| `{row.label}`{needs} | {int(row.target)} {row.target.name} | {row.does} |")
            head = "| | | "
    return "\n".join(lines) + "\n"


def table_mermaid(table: Sequence[Transition] = TABLE) -> str:
    """The table as a Mermaid state diagram; rows between the same two states share an arrow."""
    arrows: Dict[Tuple[State, State], List[str]] = {}
    for row in table:
        arrows.setdefault((row.source, row.target), []).append(row.label.replace(":", ""))
    lines = ["stateDiagram-v2", "    [*] --> IDLE"]
    lines += [f"    {a.name} --> {b.name}: {', '.join(labels)}" for (a, b), labels in arrows.items()]
    return "\n".join(lines) + "\n"
