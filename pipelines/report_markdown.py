"""The Markdown of the results as HTML: headings, paragraphs, tables, and of what stands in a line: code, emphasis and links."""

import html
import re


def identifier(path):
    """What a file is called in the page: he/table.md is #he_table_md. A minus stays, as it may be all that tells two names apart."""
    return re.sub(r"[^a-z0-9-]+", "_", path.lower())


def links(text):
    """(words, target) of every link and picture of a text, in order."""
    return re.findall(r"\[([^\]]*)\]\(([^)\s]+)\)", text)


def inline(text, resolve):
    """A line's marks. `resolve` turns a link's target into an address, or None where there is none to go to."""
    code = []

    def keep(match):
        code.append(f"<code>{html.escape(match[1])}</code>")
        return f"\0{len(code) - 1}\0"

    def link(match):
        address = resolve(html.unescape(match[2]))
        return f'<a href="{html.escape(address)}">{match[1]}</a>' if address else match[1]

    text = html.escape(re.sub(r"`([^`]+)`", keep, text), quote=False)
    text = re.sub(r"!?\[([^\]]*)\]\(([^)\s]+)\)", link, text)
    text = re.sub(r"\*\*(\S(?:.*?\S)?)\*\*", r"<strong>\1</strong>", text)
    text = re.sub(r"(?<![\w*])\*(\S(?:[^*]*?\S)?)\*(?![\w*])", r"<em>\1</em>", text)
    return re.sub("\0(\\d+)\0", lambda match: code[int(match[1])], text)


def cells(line):
    return [cell.strip() for cell in line.strip().strip("|").split("|")]


def table(header, rows, show=lambda text: html.escape(text, quote=False)):
    """A table that the page's script sorts by the column whose head is clicked. Cells and rows end where the next begins, as
    HTML allows: with their end tags long tables would be a third larger."""
    head = "".join(f'<th scope="col"><button type="button">{show(cell) or "&nbsp;"}</button></th>' for cell in header)
    body = "".join("<tr>" + "".join(f"<td>{show(cell)}" for cell in row) for row in rows)
    return f'<div class="table"><table><thead><tr>{head}</tr></thead>\n<tbody>{body}</tbody></table></div>'


def to_html(text, resolve=lambda target: None, level=1):
    """The text as HTML, its first level of headings as h<level>."""
    show = lambda line: inline(line, resolve)  # noqa: E731
    parts = []
    for block in re.split(r"\n\s*\n", text.strip()):
        lines = block.splitlines()
        while lines and (heading := re.match(r"(#+) +(.*)", lines[0])):
            depth = min(6, len(heading[1]) + level - 1)
            parts.append(f"<h{depth}>{show(heading[2])}</h{depth}>")
            lines.pop(0)
        first = next((i for i, line in enumerate(lines) if line.startswith("|")), len(lines))
        if first:
            parts.append(f"<p>{show(' '.join(lines[:first]))}</p>")
        if rows := lines[first:]:
            parts.append(table(cells(rows[0]), [cells(row) for row in rows[2:]], show))
    return "\n".join(parts)
