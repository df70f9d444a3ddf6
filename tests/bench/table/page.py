"""The table as a page that loads nothing, in the style of the program's own pages."""
import json
import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
PAGES = HERE.parents[2] / "pages"
sys.path.insert(0, str(PAGES))

import embed_pages  # noqa: E402
import table  # noqa: E402


def shown(row):
    name, ours, other, other_name, ratio, goal, clock = table.cells(row)
    return {"name": name, "kind": row.kind, "ours": ours, "other": other, "other_name": other_name, "ratio": row.ratio,
            "ratio_text": ratio, "goal": row.goal, "goal_text": goal, "clock": clock, "means": row.means, "detail": row.detail}


def page_of(facts, rows):
    """The whole page as text."""
    files = embed_pages.Files(HERE, {"pages": PAGES})
    text = embed_pages.whole_page(files, "bench_page.html")
    groups = [{"name": group, "rows": [shown(row) for row in members]} for group, members in table.by_group(rows).items()]
    # Inside a script element no text may close it or open a comment; \\u003c is the same character to JSON.
    data = json.dumps({"facts": facts, "groups": groups}, ensure_ascii=False, allow_nan=False).replace("<", "\\u003c")
    return text.replace(embed_pages.DATA, embed_pages.DATA.replace("></", f">{data}</"))
